#include "runtime_eval/weights_file/sha256.h"

#include <gtest/gtest.h>

#include <string>

namespace nlg {
namespace {

std::string digestOf(const std::string& bytes, Sha256::Path path = Sha256::Path::fastest) {
  Sha256 hash(path);
  hash.add(bytes.data(), bytes.size());
  return hexadecimal(hash.finish());
}

// FIPS 180-4's own examples, and the million of a's that came with them
TEST(Sha256, GivesTheDigestsOfTheStandard) {
  for (const Sha256::Path path : {Sha256::Path::fastest, Sha256::Path::portable}) {
    EXPECT_EQ(digestOf("", path), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(digestOf("abc", path), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(digestOf("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq", path),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(digestOf(std::string(1000000, 'a'), path), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  }
}

std::string numberedBytes(size_t count) {
  std::string bytes;
  for (size_t i = 0; i < count; ++i) bytes += static_cast<char>(i * 131 + i / 256);
  return bytes;
}

TEST(Sha256, IsTheSameByEitherPathAtEveryLength) {
  for (size_t count = 0; count < 300; ++count) {
    const std::string bytes = numberedBytes(count);
    EXPECT_EQ(digestOf(bytes), digestOf(bytes, Sha256::Path::portable)) << count << " bytes";
  }
}

TEST(Sha256, DoesNotDependOnHowBytesAreHandedIn) {
  const std::string bytes = numberedBytes(1000);
  for (const size_t piece : {1u, 3u, 63u, 64u, 65u, 200u}) {
    Sha256 hash;
    for (size_t at = 0; at < bytes.size(); at += piece) hash.add(bytes.data() + at, std::min(piece, bytes.size() - at));
    EXPECT_EQ(hexadecimal(hash.finish()), digestOf(bytes)) << "pieces of " << piece;
  }
}

}  // namespace
}  // namespace nlg
