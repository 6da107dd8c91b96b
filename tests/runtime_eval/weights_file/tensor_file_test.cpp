#include "runtime_eval/weights_file/tensor_file.h"

#include <gtest/gtest.h>

#include <cstring>

#include "runtime_eval/weights_file/safetensors_layout.h"
#include "tests/damage.h"

namespace nlg {
namespace {

struct Lists {
  std::vector<uint8_t> u8{1, 2, 255};
  std::vector<uint32_t> u32{0xffffffffu, 7};
  std::vector<uint64_t> u64{~uint64_t{0}, 1};
  std::vector<int32_t> i32{-5, 4};
  std::vector<Half> f16{{0x3c00}, {0x8001}};
  std::vector<float> f32{1.5f, -0.0f, 3e-20f};
  std::vector<double> f64{1e300};
  std::vector<float> none;
  bool operator==(const Lists&) const = default;
};

std::string bytesOf(const Lists& lists, const std::map<std::string, std::string>& metadata = {{"note", "quote \" é"}}) {
  TensorFileWriter writer;
  writer.add("u8", lists.u8);
  writer.add("u32", lists.u32);
  writer.add("u64", lists.u64);
  writer.add("i32", lists.i32);
  writer.add("f16", lists.f16);
  writer.add("f32", lists.f32);
  writer.add("none", lists.none);
  writer.add("f64", lists.f64);
  std::string bytes;
  const FileResult result = writer.serialize(metadata, &bytes);
  EXPECT_TRUE(result.ok()) << result.detail;
  return bytes;
}

FileResult readLists(std::string_view bytes, Lists* lists) {
  TensorFileReader reader;
  FileResult result = reader.openBytes(bytes);
  const auto take = [&](const char* name, auto* values) {
    if (result.ok()) result = reader.read(name, values);
  };
  take("u8", &lists->u8);
  take("u32", &lists->u32);
  take("u64", &lists->u64);
  take("i32", &lists->i32);
  take("f16", &lists->f16);
  take("f32", &lists->f32);
  take("none", &lists->none);
  take("f64", &lists->f64);
  return result;
}

// A file with this header, padded with spaces to a multiple of 64, and so many zeros behind it.
std::string fileWith(std::string header, size_t data_bytes) {
  header.append((64 - (8 + header.size()) % 64) % 64, ' ');
  const uint64_t length = header.size();
  std::string bytes(sizeof length, '\0');
  std::memcpy(bytes.data(), &length, sizeof length);
  return bytes + header + std::string(data_bytes, '\0');
}

TEST(TensorFile, ReadsBackEveryType) {
  Lists lists, read{{}, {}, {}, {}, {}, {}, {}, {1.0f}};
  const std::string bytes = bytesOf(lists);
  const FileResult result = readLists(bytes, &read);
  ASSERT_TRUE(result.ok()) << result.detail;
  EXPECT_EQ(read, lists);
  TensorFileReader reader;
  ASSERT_TRUE(reader.openBytes(bytes).ok());
  EXPECT_EQ(reader.metadata(), (std::map<std::string, std::string>{{"note", "quote \" é"}}));
  EXPECT_EQ(reader.dtypeOf("f16"), "F16");
  EXPECT_EQ(reader.dtypeOf("other"), "");
}

TEST(TensorFile, IsTheSameBytesForTheSameLists) { EXPECT_EQ(bytesOf({}), bytesOf({})); }

TEST(TensorFile, RefusesWhatIsDamaged) {
  expectDamageIsRefused(bytesOf({}), [](const std::string& bytes) { return TensorFileReader().openBytes(bytes).detail; });
}

TEST(TensorFile, RefusesTensorsOfAnotherNameTypeOrShape) {
  TensorFileReader reader;
  const std::string bytes = bytesOf({});
  ASSERT_TRUE(reader.openBytes(bytes).ok());
  std::vector<float> floats;
  EXPECT_EQ(reader.read("f33", &floats).status, FileStatus::tensor_missing);
  EXPECT_EQ(reader.read("u32", &floats).status, FileStatus::tensor_unexpected);
  for (const char* shape : {"[]", "[1,1]"}) {
    const std::string file = fileWith(std::string(R"({"a":{"dtype":"F32","shape":)") + shape + R"(,"data_offsets":[0,4]}})", 4);
    ASSERT_TRUE(reader.openBytes(file).ok());
    EXPECT_EQ(reader.read("a", &floats).status, FileStatus::tensor_unexpected) << shape;
  }
}

}  // namespace
}  // namespace nlg
