#include "runtime_eval/weights_file/weights_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "runtime_eval/weights_file/header_parser.h"
#include "tests/damage.h"
#include "tests/runtime_eval/weights_file/digest_edits.h"

namespace nlg {
namespace {

WeightsFile smallFile() {
  WeightsFile file;
  file.tensors["bias"] = {{3}, {1.0f, -2.5f, 3e-20f}};
  file.tensors["empty"] = {{0, 5}, {}};
  file.tensors["layer.0"] = {{2, 4, 2}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}};
  file.tensors["slope"] = {{}, {0.01f}};
  file.tensors["z.half"] = {{3, 1}, {-65504.0f, 0x1p-24f, 0.333251953125f}, WeightsDtype::float16};
  file.metadata = {{"representation", "tent_mlp"}, {"note", "quote \" back\\slash\n tab\t \x01 é 𝄞"}, {"", "empty key"}};
  return file;
}

void expectEqual(const WeightsFile& a, const WeightsFile& b) {
  EXPECT_EQ(a.metadata, b.metadata);
  ASSERT_EQ(a.tensors.size(), b.tensors.size());
  for (const auto& [name, tensor] : a.tensors) {
    ASSERT_EQ(b.tensors.count(name), 1u) << name;
    EXPECT_EQ(tensor.shape, b.tensors.at(name).shape) << name;
    EXPECT_EQ(tensor.values, b.tensors.at(name).values) << name;
    EXPECT_EQ(tensor.dtype, b.tensors.at(name).dtype) << name;
  }
}

FileStatus statusOf(const std::string& bytes) {
  WeightsFile file = smallFile();
  const FileResult result = parseWeights(bytes, &file);
  EXPECT_EQ(result.ok(), result.detail.empty() || result.detail == kNoDigest) << result.detail;
  if (!result.ok()) {
    EXPECT_TRUE(file.tensors.empty() && file.metadata.empty()) << result.detail;
  }
  return result.status;
}

nlohmann::json headerOf(const std::string& bytes, size_t* data_offset) {
  uint64_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof length);
  *data_offset = sizeof length + length;
  return nlohmann::json::parse(bytes.substr(sizeof length, length));
}

// But for the digest.
decltype(WeightsFile::metadata) metadataOf(const nlohmann::json& header) {
  auto metadata = header["__metadata__"].get<decltype(WeightsFile::metadata)>();
  metadata.erase(kDigestKey);
  return metadata;
}

TEST(WeightsWriter, RoundTrips) {
  WeightsFile read;
  const FileResult result = parseWeights(serializeWeights(smallFile()), &read);
  ASSERT_TRUE(result.ok()) << result.detail;
  expectEqual(smallFile(), read);
  ASSERT_TRUE(parseWeights(serializeWeights({}), &read).ok());
  expectEqual({}, read);
}

TEST(WeightsWriter, GivesTheSameBytesForTheSameContent) {
  EXPECT_EQ(serializeWeights(smallFile()), serializeWeights(smallFile()));
}

// The header as an independent JSON library sees it, against the rules of the safetensors format.
TEST(WeightsWriter, WritesAValidSafetensorsHeader) {
  const std::string bytes = serializeWeights(smallFile());
  size_t data_offset = 0;
  const nlohmann::json header = headerOf(bytes, &data_offset);
  EXPECT_EQ(data_offset % 64, 0u);
  EXPECT_EQ(bytes[8], '{');
  EXPECT_EQ(metadataOf(header), smallFile().metadata);
  std::map<size_t, size_t> ranges;  // begin → end; the empty tensor shares its begin with the next
  for (const auto& [name, tensor] : header.items()) {
    if (name == "__metadata__") continue;
    const size_t begin = tensor["data_offsets"][0], end = tensor["data_offsets"][1];
    const bool padding = name.rfind("padding.", 0) == 0;
    const bool half = name == "z.half";
    EXPECT_EQ(tensor["dtype"], padding ? "U8" : half ? "F16" : "F32") << name;
    size_t count = 1;
    for (const size_t n : tensor["shape"]) count *= n;
    EXPECT_EQ(end - begin, count * (padding ? 1 : half ? 2 : 4)) << name;
    if (!padding) {
      EXPECT_EQ((data_offset + begin) % 64, 0u) << name;
    }
    if (begin != end) {
      EXPECT_TRUE(ranges.emplace(begin, end).second) << name;
    }
  }
  size_t covered = 0;
  for (const auto& [begin, end] : ranges) {
    EXPECT_EQ(begin, covered);
    covered = end;
  }
  EXPECT_EQ(data_offset + covered, bytes.size());
}

TEST(WeightsWriter, RoundsToFloat16OnlyWhatFits) {
  WeightsTensor tensor{{4}, {1.0f, 0.1f, -3e-9f, 65504.0f}};
  ASSERT_TRUE(roundToFloat16("a", &tensor).ok());
  EXPECT_EQ(tensor.dtype, WeightsDtype::float16);
  // 0.1 is 1638.4 units of 2^-14; what is less than half of 2^-24 becomes zero
  EXPECT_EQ(tensor.values, (std::vector<float>{1.0f, 1638.0f / 16384, -0.0f, 65504.0f}));
  WeightsTensor large{{2}, {1.0f, 1e5f}};
  const FileResult refused = roundToFloat16("a", &large);
  EXPECT_EQ(refused.status, FileStatus::value_out_of_range);
  EXPECT_EQ(refused.detail, "tensor \"a\": value 1 is beyond float16: 100000.000000");
  EXPECT_EQ(large.dtype, WeightsDtype::float32);
  EXPECT_EQ(large.values, (std::vector<float>{1.0f, 1e5f}));
}

TEST(WeightsReader, ReadsAFileAndSaysWhyNot) {
  const std::string path = (std::filesystem::temp_directory_path() / ("nlg_weights_" + std::to_string(::getpid()))).string();
  std::ofstream(path, std::ios::binary) << serializeWeights(smallFile());
  WeightsFile file;
  const FileResult result = readWeightsFile(path, &file);
  ASSERT_TRUE(result.ok()) << result.detail;
  expectEqual(smallFile(), file);
  std::filesystem::resize_file(path, 20);
  EXPECT_EQ(readWeightsFile(path, &file).status, FileStatus::header_too_large);
  EXPECT_TRUE(file.tensors.empty());
  std::filesystem::remove(path);
  const FileResult missing = readWeightsFile(path, &file);
  EXPECT_EQ(missing.status, FileStatus::cannot_open);
  EXPECT_EQ(missing.detail, path + ": No such file or directory");
}

TEST(WeightsReader, RefusesWhatIsDamaged) {
  expectDamageIsRefused(serializeWeights(smallFile()), [](const std::string& bytes) {
    WeightsFile file;
    return parseWeights(bytes, &file).detail;
  });
}

TEST(WeightsReader, ReadsFilesOfBeforeDigestsAndSaysSo) {
  WeightsFile read;
  const FileResult result = parseWeights(withoutDigest(serializeWeights(smallFile())), &read);
  ASSERT_TRUE(result.ok()) << result.detail;
  EXPECT_EQ(result.detail, kNoDigest);
  expectEqual(smallFile(), read);
}

TEST(WeightsReader, RefusesAGeneratorWithoutADigest) {
  WeightsFile file = smallFile();
  file.metadata["version"] = "1";
  EXPECT_EQ(statusOf(serializeWeights(file)), FileStatus::ok);
  EXPECT_EQ(statusOf(withoutDigest(serializeWeights(file))), FileStatus::digest_mismatch);
}

TEST(WeightsReader, RefusesNumbersThatAreNotFinite) {
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
    WeightsFile file = smallFile();
    file.tensors["layer.0"].values[7] = bad;
    const FileResult result = parseWeights(serializeWeights(file), &file);
    EXPECT_EQ(result.status, FileStatus::value_not_finite);
    EXPECT_EQ(result.detail, "tensor \"layer.0\": value 7");
    file = smallFile();
    file.tensors["z.half"].values[1] = bad;
    EXPECT_EQ(parseWeights(serializeWeights(file), &file).detail, "tensor \"z.half\": value 1");
  }
}

}  // namespace
}  // namespace nlg
