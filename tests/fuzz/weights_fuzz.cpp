// Hostile weights files for libFuzzer: whatever the bytes, the reader answers with a status and a reason, or with a generator
// that works. How to run it: CONTRIBUTING.md.
//
// A file that loads has 40 kB and more, and hardly any mutation of it hits the header. So an input comes in one of three forms,
// told apart by its first byte, and the last two are made whole files here:
//
//     any other     the file's bytes themselves
//     '{'           a header as it stands; its length, alignment and as much data as it speaks of are supplied
//     '['           a header behind the bracket, of which only names, dtypes, shapes and texts count: tensors are laid out
//                   anew
//
// A zero byte may end the header in the last two. Behind it: one signed byte, by which the data is longer than the header says,
// and bytes that fill the data over and over.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "runtime_eval/weights_file/header_parser.h"
#include "tests/fuzz/digests.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {
namespace {

// The seeds fit in; above it the sanitizer maps new pages for every input. Larger data is left to the first form.
constexpr uint64_t kMaxDataBytes = uint64_t{1} << 17;

// The data that stands in for a file's: the input's own bytes over and over, or ones.
std::string filled(std::string_view pattern, uint64_t bytes) {
  const float one = 1.0f;
  if (pattern.empty()) pattern = std::string_view(reinterpret_cast<const char*>(&one), sizeof one);
  std::string data(pattern.substr(0, bytes));
  data.reserve(bytes);
  // whole repeats of the pattern, as many again each time
  while (data.size() < bytes) data.append(data.data(), std::min<size_t>(data.size(), bytes - data.size()));
  return data;
}

// A whole file around a header: spaces up to the alignment, and as much data as the header speaks of, and `longer` bytes.
std::string fileAround(std::string_view text, int longer, std::string_view pattern) {
  WeightsHeader header;
  uint64_t data_bytes = 0;
  if (parseWeightsHeader(text, &header).empty()) {
    for (const auto& [name, tensor] : header.tensors) data_bytes = std::max(data_bytes, tensor.end);
  }
  std::string padded(text);
  padded.append((64 - (sizeof(uint64_t) + padded.size()) % 64) % 64, ' ');
  const uint64_t length = padded.size();
  std::string bytes(reinterpret_cast<const char*>(&length), sizeof length);
  const int64_t wanted = static_cast<int64_t>(std::min(data_bytes, kMaxDataBytes)) + longer;
  return bytes + padded + filled(pattern, static_cast<uint64_t>(std::max<int64_t>(wanted, 0)));
}

// A well-formed file of a header's names, shapes and texts; an empty one when that would be too large.
std::string laidOut(std::string_view text, std::string_view pattern) {
  WeightsHeader header;
  if (!parseWeightsHeader(text, &header).empty()) return {};
  WeightsFile file;
  file.metadata = header.metadata;
  file.metadata.erase(kDigestKey);  // the writer's own
  uint64_t left = kMaxDataBytes / sizeof(float);
  for (const auto& [name, tensor] : header.tensors) {
    if (name.rfind("padding.", 0) == 0) continue;
    uint64_t count = 1;
    for (const uint64_t extent : tensor.shape) {
      if (extent > left || count * extent > left) return {};
      count *= extent;
    }
    left -= count;
    const std::string data = filled(pattern, count * sizeof(float));
    WeightsTensor& values = file.tensors[name];
    values.shape = tensor.shape;
    if (tensor.dtype == "F16") values.dtype = WeightsDtype::float16;
    values.values.resize(count);
    if (count > 0) std::memcpy(values.values.data(), data.data(), data.size());
  }
  return serializeWeights(file);
}

std::string wholeFile(std::string_view input) {
  if (input.empty() || (input[0] != '{' && input[0] != '[')) return std::string(input);
  const bool lay_out = input[0] == '[';
  if (lay_out) input.remove_prefix(1);
  const size_t end = std::min(input.find('\0'), input.size());
  const int longer = end + 1 < input.size() ? static_cast<signed char>(input[end + 1]) : 0;
  const std::string_view text = input.substr(0, end), pattern = input.substr(std::min(end + 2, input.size()));
  return lay_out ? laidOut(text, pattern) : fileAround(text, longer, pattern);
}

void checkRefusal(const FileResult& result) {
  FUZZ_CHECK(!result.detail.empty(), fileStatusName(result.status));
  FUZZ_CHECK(std::strcmp(fileStatusName(result.status), "unknown") != 0, result.detail);
  for (const char c : result.detail) FUZZ_CHECK(static_cast<unsigned char>(c) >= 0x20, "one line: " + result.detail);
}

// laid_out   the bytes are what our own writer made
void load(std::string_view bytes, bool laid_out) {
  WeightsFile file;
  GeneratorData data;
  FileResult result = parseWeights(bytes, &file);
  FUZZ_CHECK(!laid_out || result.ok() || result.status == FileStatus::value_not_finite, "written, yet " + result.detail);
  FUZZ_CHECK(result.ok() || (file.tensors.empty() && file.metadata.empty()), "a refused file is left empty");
  if (result.ok()) result = generatorFromWeights(file, &data);
  if (!result.ok()) return checkRefusal(result);
  FUZZ_CHECK(result.detail.empty(), result.detail);

  static const std::string phi = filled("\x01\x80\xff\x7f\x33", kSupportPointCount);
  const Generator generator(data);
  GeneratorScratch scratch(generator);
  std::vector<float> theta(data.theta0.size());
  const auto* values = reinterpret_cast<const uint8_t*>(phi.data());
  const StoredFunction function{values, values};
  generator.generate(&function, 1, theta.data(), &scratch);
}

}  // namespace

void readOne(std::string_view bytes) {
  const std::string file = withRightDigest(wholeFile(bytes));
  // a string may own more than its text: a read past the end shall leave the allocation
  const std::vector<char> exact(file.begin(), file.end());
  load({exact.data(), exact.size()}, bytes.starts_with('[') && !exact.empty());
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
