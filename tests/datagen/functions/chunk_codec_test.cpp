#include "datagen/functions/chunk_codec.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include "datagen/dataset/hdf5_file.h"
#include "tests/damage.h"
#include "tests/temporary_folder.h"

namespace nlg {
namespace {

std::vector<uint8_t> someBytes(size_t count) {
  std::vector<uint8_t> bytes(count);
  for (size_t i = 0; i < count; ++i) bytes[i] = static_cast<uint8_t>(i * i / 50 + (i % 7 == 0 ? i * 31 : 0));
  return bytes;
}

TEST(ChunkCodec, RoundTripsEveryLength) {
  for (const size_t count : {1u, 2u, 3u, 719u, 720u, 721u, 100000u}) {
    const std::vector<uint8_t> bytes = someBytes(count), encoded = encodeChunk(bytes.data(), count);
    std::vector<uint8_t> decoded(count);
    ASSERT_TRUE(decodeChunk(encoded.data(), encoded.size(), decoded.data(), count)) << count;
    EXPECT_EQ(decoded, bytes);
    EXPECT_FALSE(decodeChunk(encoded.data(), encoded.size(), decoded.data(), count - 1)) << "a longer stream than asked for";
  }
}

// Odd and even lengths of the compressed stream: HDF5 checks the checksum with its own code.
TEST(ChunkCodec, IsWhatHdf5ItselfReads) {
  const TemporaryFolder folder;
  const std::string path = folder / "codec.h5";
  for (const size_t columns : {40u, 41u, 42u, 43u, 5000u}) {
    const std::vector<uint8_t> bytes = someBytes(8 * columns);
    {
      Hdf5Writer file(path);
      file.makeGrowing<uint8_t>("values", {columns}, 4);
      file.appendChunk("values", encodeChunk(bytes.data(), 4 * columns), 4);
      file.appendChunk("values", encodeChunk(&bytes[4 * columns], 4 * columns), 3);
      file.close();
    }
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), dataset = H5Dopen2(file, "values", H5P_DEFAULT);
    std::vector<uint8_t> read(7 * columns);
    EXPECT_GE(H5Dread(dataset, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, read.data()), 0);
    H5Dclose(dataset);
    H5Fclose(file);
    EXPECT_EQ(read, std::vector<uint8_t>(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(7 * columns)));
    EXPECT_EQ(Hdf5Reader(path).read<uint8_t>("values", {7, columns}), read);
  }
}

}  // namespace
}  // namespace nlg
