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
  const Columns columns(1000, 0);
  const Bytes coded = codedBytes(Bytes(1000, 7), columns);
  Bytes back = {1}, longer = coded, shorter(coded.begin(), coded.end() - 1);
  longer.push_back(0);
  EXPECT_FALSE(decodeBytes(coded, Columns(999, 0), &back));
  EXPECT_TRUE(back.empty());
  for (const Bytes& other : {Bytes(), longer, shorter}) EXPECT_FALSE(decodeBytes(other, columns, &back)) << other.size();
  // a count of four thousand million is not believed, nor can much come of little
  EXPECT_FALSE(decodeBytes(Bytes(codedBytes(Bytes(3, 0)).size(), 0xff), {}, &back));
  EXPECT_GT(codedBytes(Bytes(100000, 0)).size(), 100000u / 50);
}

}  // namespace
}  // namespace nlg
