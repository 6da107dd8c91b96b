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

}  // namespace
}  // namespace nlg
