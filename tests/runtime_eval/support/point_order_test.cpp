
#include <gtest/gtest.h>

#include "tests/runtime_eval/sample_fields.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {
namespace {

std::vector<const PointOrder*> allOrders() {
  std::vector<const PointOrder*> orders = {&stratumOrder()};
  for (const int resolution : kFieldResolutions) orders.push_back(&cellOrder(resolution));
  return orders;
}

TEST(PointOrder, HoldsEverySupportPointExactlyOnce) {
  for (const PointOrder* order : allOrders()) {
    SCOPED_TRACE(order->resolution);
    std::vector<int> times(kSupportPointCount, 0);
    ASSERT_EQ(order->placeCount(), order->points.padded_count);
    for (int place = 0; place < order->placeCount(); ++place) {
      const int p = order->pattern_index[place];
      if (p < 0) continue;
      ++times[p];
      const LocalPoint& point = supportPattern().points[p];
      ASSERT_EQ(placePosition(*order, place), point) << "place " << place;
      ASSERT_EQ(order->points.tent[place], tent(point)) << "place " << place;
    }
    EXPECT_EQ(times, std::vector<int>(kSupportPointCount, 1));
    EXPECT_EQ(order->points.count, kSupportPointCount);
  }
}

TEST(CellOrder, HoldsEachPlaceInItsCell) {
  for (const int resolution : kFieldResolutions) {
    SCOPED_TRACE(resolution);
    const PointOrder& order = cellOrder(resolution);
    const int cells = resolution - 1;
    ASSERT_EQ(order.cell_begin.size(), static_cast<size_t>(cells) * cells * cells + 1);
    for (int cell = 0; cell < cells * cells * cells; ++cell) {
      const int along[3] = {cell % cells, cell / cells % cells, cell / (cells * cells)};
      int filled = 0;
      for (int place = order.cell_begin[cell]; place < order.cell_begin[cell + 1]; ++place) {
        filled += order.pattern_index[place] < 0;
        for (int axis = 0; axis < 3; ++axis) {
          const double low = 2.0 * along[axis] / cells - 1.0, position = placePosition(order, place)[axis];
          ASSERT_TRUE(position > low && position < low + 2.0 / cells) << "cell " << cell << ", place " << place;
        }
      }
      EXPECT_LT(filled, kPointGroup) << "cell " << cell;
    }
  }
}

}  // namespace
}  // namespace nlg
