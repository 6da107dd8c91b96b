#include "bake/again/kept_functions_file.h"

#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/weights_file/tensor_file.h"
#include "tool/command/file_info.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char *kKind = "nlg-kept-functions", *kVersion = "3", *kExpected = "theta that a bake kept";
constexpr size_t kCheckNumbers = 4 * kThetaWordCount, kCheckCounts = 2 * kThetaWordCount;

// The file's tensors, by theta.
struct Arrays {
  std::vector<uint64_t> key;  // of the function's samples, two each
  std::vector<uint8_t> generator, chosen_first, bits, ended, stop;
  std::vector<double> check;         // 4 numbers of 4 words each
  std::vector<int32_t> check_count;  // 2 of them
  std::vector<float> theta;
};

// One list of names for the reader and the writer.
template <class Visit, class Of>
void forEachTensor(Of& arrays, const Visit& visit) {
  visit("theta.key", arrays.key);
  visit("theta.generator", arrays.generator);
  visit("theta.chosen_first", arrays.chosen_first);
  visit("theta.bits", arrays.bits);
  visit("theta.ended", arrays.ended);
  visit("theta.stop", arrays.stop);
  visit("theta.check", arrays.check);
  visit("theta.check_count", arrays.check_count);
  visit("theta", arrays.theta);
}

void add(const KeptKey& key, const KeptTheta& theta, Arrays* arrays) {
  arrays->key.insert(arrays->key.end(), key.begin(), key.end());
  const ThetaRecord& record = theta.made.record;
  arrays->generator.push_back(theta.made.generator);
  arrays->chosen_first.push_back(theta.chosen_first);
  arrays->bits.push_back(static_cast<uint8_t>(theta.made.larger_ran | record.took_fit << 1 | record.refined << 2));
  arrays->ended.push_back(static_cast<uint8_t>(record.ended));
  arrays->stop.push_back(static_cast<uint8_t>(record.refinement_stop));
  for (const FunctionCheck& check : record.check) {
    for (const double number : {check.rmse, check.blend_rmse, check.leak_mean, check.leak_share}) arrays->check.push_back(number);
    for (const int count : {check.valid_count, check.zero_count}) arrays->check_count.push_back(count);
  }
  arrays->theta.insert(arrays->theta.end(), theta.made.theta.begin(), theta.made.theta.end());
}

// Takes the file's numbers one after another, once their counts are known to be right.
class Parser {
 public:
  Parser(const std::string& path, const std::vector<Representation>& representations)
      : path_(path), representations_(representations) {}

  KeptThetas run(const TensorFileReader& reader) {
    forEachTensor(arrays_, [&](const char* name, auto& values) { requireRead(path_, reader.read(name, &values), kExpected); });
    checkCounts();
    KeptThetas thetas;
    const float* numbers = arrays_.theta.data();
    for (size_t t = 0; t < arrays_.generator.size(); ++t)
      thetas[{arrays_.key[2 * t], arrays_.key[2 * t + 1]}] = thetaAt(t, &numbers);
    return thetas;
  }

 private:
  void require(bool holds, const char* place, const char* expected) const {
    if (!holds) throw InputError(path_, place, expected, "something else");
  }

  void checkCounts() const {
    const Arrays& a = arrays_;
    const size_t thetas = a.generator.size();
    require(a.key.size() == 2 * thetas && a.chosen_first.size() == thetas && a.bits.size() == thetas &&
                a.ended.size() == thetas && a.stop.size() == thetas && a.check.size() == kCheckNumbers * thetas &&
                a.check_count.size() == kCheckCounts * thetas,
            "theta", "lists of one length");
    uint64_t numbers = 0;
    for (size_t t = 0; t < thetas; ++t) {
      require(a.generator[t] < representations_.size() && a.chosen_first[t] < representations_.size(), "theta.generator",
              "a representation of the bake");
      require(a.ended[t] < kThetaStageCount && a.stop[t] < kFitStopCount, "theta.ended",
              "a stage, and a reason why its fit stopped");
      numbers += static_cast<uint64_t>(representations_[a.generator[t]].thetaCount());
    }
    require(numbers == a.theta.size(), "theta", "as many numbers as the representations have");
    // of what a network said, before anything mended it, even a check need not be
    require(allFinite(a.theta), "theta", "finite numbers");
  }

  KeptTheta thetaAt(size_t t, const float** numbers) const {
    KeptTheta theta;
    theta.chosen_first = arrays_.chosen_first[t];
    theta.made.generator = arrays_.generator[t];
    theta.made.larger_ran = arrays_.bits[t] & 1;
    ThetaRecord& record = theta.made.record;
    record.took_fit = arrays_.bits[t] >> 1 & 1;
    record.refined = arrays_.bits[t] >> 2 & 1;
    record.ended = static_cast<ThetaStage>(arrays_.ended[t]);
    record.refinement_stop = static_cast<FitStop>(arrays_.stop[t]);
    const double* check = &arrays_.check[kCheckNumbers * t];
    const int32_t* count = &arrays_.check_count[kCheckCounts * t];
    for (FunctionCheck& of_word : record.check) {
      of_word = {check[0], check[1], check[2], check[3], count[0], count[1]};
      check += 4, count += 2;
    }
    const int D = representations_[theta.made.generator].thetaCount();
    theta.made.theta.assign(*numbers, *numbers + D);
    *numbers += D;
    return theta;
  }

  const std::string& path_;
  const std::vector<Representation>& representations_;
  Arrays arrays_;
};

std::string textOf(const TensorFileReader& reader, const char* key) {
  const auto found = reader.metadata().find(key);
  return found == reader.metadata().end() ? std::string() : found->second;
}

bool isKept(const TensorFileReader& reader) { return reader.hasDigest() && textOf(reader, "kind") == kKind; }

// The first thing that has changed: "adam_steps was 1000 and is 10".
std::string changeOf(const Json& before, const Json& now) {
  for (const auto& [name, value] : now.items()) {
    const Json was = before.is_object() ? before.value(name, Json()) : Json();
    if (was == value) continue;
    if (value.is_object()) return changeOf(was, value);
    return name + " was " + was.dump() + " and is " + value.dump();
  }
  return "something was that is no more";
}

}  // namespace

std::string keptBytes(const KeptThetas& thetas, const Json& origin) {
  Arrays arrays;
  for (const auto& [key, theta] : thetas) add(key, theta, &arrays);
  TensorFileWriter writer;
  forEachTensor(std::as_const(arrays), [&](const char* name, const auto& values) { writer.add(name, values); });
  std::string bytes;
  const FileResult result = writer.serialize({{"kind", kKind}, {"version", kVersion}, {"origin", origin.dump()}}, &bytes);
  if (!result.ok()) throw NumericalError("bake: kept theta: " + result.detail);
  return bytes;
}

std::optional<Json> describeKept(const std::string& path) {
  TensorFileReader reader;
  // what cannot be read at all is for the reader of whatever else it is
  if (!reader.openFile(path).ok() || !isKept(reader)) return std::nullopt;
  std::vector<uint8_t> generator;
  requireRead(path, reader.read("theta.generator", &generator), kExpected);
  return Json{{"kind", kKind},
              {"thetas", generator.size()},
              {"verified", kVerifiedByDigest},
              {"origin", Json::parse(textOf(reader, "origin"), nullptr, false)}};
}

KeptThetas readKept(const std::string& path, const Json& origin, const std::vector<Representation>& representations,
                    std::string* told) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) {
    *told = path + ": not there yet, all theta are made anew";
    return {};
  }
  TensorFileReader reader;
  requireRead(path, reader.openFile(path), kExpected);
  if (!isKept(reader))
    throw InputError(path, "kind", std::string(kExpected) + ", or a new name", "another kind of file, which is not overwritten");
  const std::string version = textOf(reader, "version");
  const Json before = Json::parse(textOf(reader, "origin"), nullptr, false);
  // what another program, other options or other weights made may differ in any bit
  if (version != kVersion || before != origin) {
    *told = path + ": not used, " + (version != kVersion ? "of another version" : changeOf(before, origin)) +
            "; all theta are made anew";
    return {};
  }
  return Parser(path, representations).run(reader);
}

}  // namespace nlg
