#include "runtime_eval/numbers/coded_bytes.h"

#include <gtest/gtest.h>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

using Bytes = std::vector<uint8_t>;
using Columns = std::vector<uint16_t>;

TEST(CodedBytes, ComeBack) {
  Random random(1);
  for (const size_t count : {0u, 1u, 2u, 100u, 70000u}) {
    for (const uint32_t width : {0u, 1u, 7u, 300u}) {
      Bytes bytes;
      Columns columns;
      for (size_t i = 0; i < count; ++i) {
        // each column around another number
        const auto column = static_cast<uint16_t>(width == 0 ? 0 : i % width);
        bytes.push_back(static_cast<uint8_t>(17 * column + random.below(8)));
        if (width > 0) columns.push_back(column);
      }
      const Bytes coded = codedBytes(bytes, columns);
      Bytes back = {1, 2};
      ASSERT_TRUE(decodeBytes(coded, columns, &back)) << count << ' ' << width;
      EXPECT_EQ(back, bytes);
      if (count == 70000u && width == 7u) {
        EXPECT_LT(coded.size(), 3.2 / 8 * count) << "three bits each, where columns are known";
        EXPECT_GT(codedBytes(bytes).size(), 4.5 / 8 * count);
      }
    }
  }
}

TEST(CodedBytes, OtherBytesAreRefused) {
  const Bytes bytes(1000, 7);
  const Columns columns(1000, 0);
  const Bytes coded = codedBytes(bytes, columns);
  Bytes back = {1};
  EXPECT_FALSE(decodeBytes(coded, Columns(999, 0), &back));
  EXPECT_TRUE(back.empty());
  EXPECT_FALSE(decodeBytes({}, columns, &back));
  for (const size_t count : {size_t{1}, size_t{4}, coded.size() - 1})
    EXPECT_FALSE(decodeBytes(Bytes(coded.begin(), coded.begin() + static_cast<ptrdiff_t>(count)), {}, &back)) << count;
  Bytes longer = coded;
  longer.push_back(0);
  EXPECT_FALSE(decodeBytes(longer, {}, &back));
  // a count of four thousand million is not believed
  Bytes many = codedBytes(Bytes(3, 0));
  for (uint8_t& byte : many) byte = 0xff;
  EXPECT_FALSE(decodeBytes(many, {}, &back));
  // nor can much come of little
  EXPECT_GT(codedBytes(Bytes(100000, 0)).size(), 100000u / 50);
  Random random(2);
  for (int trial = 0; trial < 300; ++trial) {
    Bytes other(random.below(60));
    for (uint8_t& byte : other) byte = static_cast<uint8_t>(random.below(256));
    decodeBytes(other, {}, &back);
    EXPECT_LE(back.size(), 50 * other.size());
  }
}

}  // namespace
}  // namespace nlg
