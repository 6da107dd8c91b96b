#include "bake/again/kept_functions_file.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include <nlohmann/json.hpp>

#include "runtime_eval/numbers/finite.h"
#include "runtime_eval/weights_file/tensor_file.h"
#include "tool/command/file_info.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char *kKind = "nlg-kept-functions", *kVersion = "2", *kExpected = "functions that a bake kept";
constexpr uint32_t kNoFunction = 0xffffffffu;
constexpr double kNoTent = -1.0;
constexpr size_t kCheckNumbers = 4 * kThetaWordCount, kCheckCounts = 2 * kThetaWordCount;

// The file's tensors.
struct Arrays {
  // by probe
  std::vector<uint64_t> probe_key;  // two each
  std::vector<uint8_t> outcome, flags;
  std::vector<float> eye;  // three each
  std::vector<double> tent_rmse;
  std::vector<uint32_t> function;
  std::vector<uint16_t> question_count;
  // by question; of points as many as it has
  std::vector<uint8_t> question;
  std::vector<uint16_t> point;
  // by function
  std::vector<uint64_t> function_key;  // two each
  std::vector<uint32_t> packed_bytes;
  std::vector<uint8_t> packed, has_theta;
  // by theta
  std::vector<uint8_t> generator, chosen_first, bits, ended, stop;
  std::vector<double> check;         // 4 numbers of 4 words each
  std::vector<int32_t> check_count;  // 2 of them
  std::vector<float> theta;
};

// One list of names for the reader and the writer.
template <class Visit, class Of>
void forEachTensor(Of& arrays, const Visit& visit) {
  visit("probe.key", arrays.probe_key);
  visit("probe.outcome", arrays.outcome);
  visit("probe.flags", arrays.flags);
  visit("probe.eye", arrays.eye);
  visit("probe.tent_rmse", arrays.tent_rmse);
  visit("probe.function", arrays.function);
  visit("probe.question_count", arrays.question_count);
  visit("question", arrays.question);
  visit("question.point", arrays.point);
  visit("function.key", arrays.function_key);
  visit("function.packed_bytes", arrays.packed_bytes);
  visit("function.packed", arrays.packed);
  visit("function.has_theta", arrays.has_theta);
  visit("theta.generator", arrays.generator);
  visit("theta.chosen_first", arrays.chosen_first);
  visit("theta.bits", arrays.bits);
  visit("theta.ended", arrays.ended);
  visit("theta.stop", arrays.stop);
  visit("theta.check", arrays.check);
  visit("theta.check_count", arrays.check_count);
  visit("theta", arrays.theta);
}

uint8_t bitsOf(const FarQuestion& question) {
  return static_cast<uint8_t>(static_cast<int>(question.kind) | question.solid << 1 | question.disputed << 2 |
                              question.point_count << 3);
}

FarQuestion questionOf(uint8_t bits) {
  FarQuestion question;
  question.kind = static_cast<FarQuestion::Kind>(bits & 1);
  question.solid = bits >> 1 & 1;
  question.disputed = bits >> 2 & 1;
  question.point_count = static_cast<uint8_t>(bits >> 3);
  return question;
}

void add(const KeptTheta& theta, Arrays* arrays) {
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

  KeptProbes run(const TensorFileReader& reader) {
    forEachTensor(arrays_, [&](const char* name, auto& values) { requireRead(path_, reader.read(name, &values), kExpected); });
    checkCounts();
    readFunctions();
    return readProbes();
  }

 private:
  void require(bool holds, const char* place, const char* expected) const {
    if (!holds) throw InputError(path_, place, expected, "something else");
  }

  void checkCounts() const {
    const Arrays& a = arrays_;
    const size_t probes = a.outcome.size(), functions = a.has_theta.size(), thetas = a.generator.size();
    require(a.probe_key.size() == 2 * probes && a.flags.size() == probes && a.eye.size() == 3 * probes &&
                a.tent_rmse.size() == probes && a.function.size() == probes && a.question_count.size() == probes,
            "probe", "lists of one length");
    require(std::all_of(a.eye.begin(), a.eye.end(), [](float e) { return e >= -1.0f && e <= 1.0f; }), "probe.eye",
            "a point of the support");
    require(std::accumulate(a.question_count.begin(), a.question_count.end(), uint64_t{0}) == a.question.size(), "question",
            "as many questions as probes have");
    uint64_t points = 0;
    for (const uint8_t bits : a.question) {
      const size_t count = questionOf(bits).point_count;
      require(count >= 1 && count <= FarQuestion::kMostPoints, "question", "1 to 5 points");
      points += count;
    }
    require(points == a.point.size() &&
                std::all_of(a.point.begin(), a.point.end(), [](uint16_t p) { return p < kSupportPointCount; }),
            "question.point", "as many support points as questions have");
    require(a.function_key.size() == 2 * functions && a.packed_bytes.size() == functions &&
                std::accumulate(a.packed_bytes.begin(), a.packed_bytes.end(), uint64_t{0}) == a.packed.size(),
            "function", "lists of one length");
    require(static_cast<size_t>(std::count(a.has_theta.begin(), a.has_theta.end(), 1)) == thetas &&
                std::all_of(a.has_theta.begin(), a.has_theta.end(), [](uint8_t has) { return has <= 1; }),
            "function.has_theta", "1 for each theta, else 0");
    require(a.chosen_first.size() == thetas && a.bits.size() == thetas && a.ended.size() == thetas && a.stop.size() == thetas &&
                a.check.size() == kCheckNumbers * thetas && a.check_count.size() == kCheckCounts * thetas,
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

  void readFunctions() {
    const uint8_t* packed = arrays_.packed.data();
    const float* numbers = arrays_.theta.data();
    size_t theta = 0;
    for (size_t f = 0; f < arrays_.has_theta.size(); ++f) {
      functions_.push_back(std::make_shared<KeptFunction>());
      KeptFunction& function = *functions_.back();
      function.key = {arrays_.function_key[2 * f], arrays_.function_key[2 * f + 1]};
      function.packed.assign(packed, packed + arrays_.packed_bytes[f]);
      packed += arrays_.packed_bytes[f];
      if (arrays_.has_theta[f]) function.theta = thetaAt(theta++, &numbers);
    }
  }

  KeptProbes readProbes() const {
    KeptProbes probes(arrays_.outcome.size());
    size_t question = 0, point = 0;
    for (size_t p = 0; p < probes.size(); ++p) {
      KeptProbe& probe = probes[p];
      probe.key = {arrays_.probe_key[2 * p], arrays_.probe_key[2 * p + 1]};
      require(arrays_.outcome[p] <= static_cast<uint8_t>(ProbeOutcome::empty), "probe.outcome", "0 to 3");
      probe.outcome = static_cast<ProbeOutcome>(arrays_.outcome[p]);
      probe.flags = arrays_.flags[p];
      std::copy_n(&arrays_.eye[3 * p], 3, probe.eye.begin());
      if (arrays_.tent_rmse[p] != kNoTent) probe.bare_tent_rmse = arrays_.tent_rmse[p];
      const uint32_t function = arrays_.function[p];
      require(function < functions_.size() || function == kNoFunction, "probe.function", "a function, or none");
      if (function != kNoFunction) probe.function = functions_[function];
      require(probe.function == nullptr || !probe.bare_tent_rmse, "probe.function", "no function of a bare tent");
      require((probe.outcome == ProbeOutcome::function) == (probe.function != nullptr || probe.bare_tent_rmse.has_value()),
              "probe.function", "a function if the outcome says so");
      // what was asked of the scene beyond the support, and what it answered
      for (uint16_t q = 0; q < arrays_.question_count[p]; ++q) {
        FarQuestion asked = questionOf(arrays_.question[question++]);
        for (size_t i = 0; i < asked.point_count; ++i) asked.points[i] = arrays_.point[point++];
        probe.asked.push_back(asked);
      }
    }
    return probes;
  }

  const std::string& path_;
  const std::vector<Representation>& representations_;
  Arrays arrays_;
  std::vector<std::shared_ptr<KeptFunction>> functions_;
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

std::string keptBytes(const KeptProbes& probes, const Json& origin) {
  Arrays arrays;
  std::unordered_map<const KeptFunction*, uint32_t> number_of;
  // each function once, in the order of the probes that have it first
  const auto numberOf = [&](const KeptFunction& function) {
    const auto [place, is_new] = number_of.emplace(&function, static_cast<uint32_t>(number_of.size()));
    if (!is_new) return place->second;
    arrays.function_key.insert(arrays.function_key.end(), function.key.begin(), function.key.end());
    arrays.packed_bytes.push_back(static_cast<uint32_t>(function.packed.size()));
    arrays.packed.insert(arrays.packed.end(), function.packed.begin(), function.packed.end());
    arrays.has_theta.push_back(function.theta.has_value());
    if (function.theta) add(*function.theta, &arrays);
    return place->second;
  };
  for (const KeptProbe& probe : probes) {
    arrays.probe_key.insert(arrays.probe_key.end(), probe.key.begin(), probe.key.end());
    arrays.outcome.push_back(static_cast<uint8_t>(probe.outcome));
    arrays.flags.push_back(probe.flags);
    arrays.eye.insert(arrays.eye.end(), probe.eye.begin(), probe.eye.end());
    arrays.tent_rmse.push_back(probe.bare_tent_rmse.value_or(kNoTent));
    arrays.function.push_back(probe.function ? numberOf(*probe.function) : kNoFunction);
    arrays.question_count.push_back(static_cast<uint16_t>(probe.asked.size()));
    for (const FarQuestion& asked : probe.asked) {
      arrays.question.push_back(bitsOf(asked));
      arrays.point.insert(arrays.point.end(), asked.points.begin(), asked.points.begin() + asked.point_count);
    }
  }
  TensorFileWriter writer;
  forEachTensor(std::as_const(arrays), [&](const char* name, const auto& values) { writer.add(name, values); });
  std::string bytes;
  const FileResult result = writer.serialize({{"kind", kKind}, {"version", kVersion}, {"origin", origin.dump()}}, &bytes);
  if (!result.ok()) throw NumericalError("bake: kept functions: " + result.detail);
  return bytes;
}

std::optional<Json> describeKept(const std::string& path) {
  TensorFileReader reader;
  // what cannot be read at all is for the reader of whatever else it is
  if (!reader.openFile(path).ok() || !isKept(reader)) return std::nullopt;
  const auto countOf = [&](const char* name) {
    std::vector<uint8_t> values;
    requireRead(path, reader.read(name, &values), kExpected);
    return values.size();
  };
  return Json{{"kind", kKind},
              {"probes", countOf("probe.outcome")},
              {"functions", countOf("function.has_theta")},
              {"thetas", countOf("theta.generator")},
              {"verified", kVerifiedByDigest},
              {"origin", Json::parse(textOf(reader, "origin"), nullptr, false)}};
}

KeptProbes readKept(const std::string& path, const Json& origin, const std::vector<Representation>& representations,
                    std::string* told) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) {
    *told = path + ": not there yet, all functions are made anew";
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
            "; all functions are made anew";
    return {};
  }
  return Parser(path, representations).run(reader);
}

}  // namespace nlg
