#include "runtime_eval/support/point_order.h"

#include <array>

namespace nlg {
namespace {

PointOrder makeStratumOrder() {
  PointOrder order;
  order.points = stratifiedSupportPoints();
  for (int k = 0; k < kStratumCount; ++k) {
    order.batch_begin.push_back(k * kStratumPointCount);
  }
  for (int place = 0; place < kSupportPointCount; ++place) order.pattern_index.push_back(stratifiedPatternIndex(place));
  order.minibatch_places = kMinibatchPointCount;
  order.batch_begin.push_back(kSupportPointCount);
  return order;
}

// Which of `count` equal parts of [-1, 1] holds x: exact, because no support point lies on a border in float (they are multiples
// of 2^-16, and (x + 1) * count / 2 rounds to no integer from below).
int cellAlong(float x, int count) { return static_cast<int>((static_cast<double>(x) + 1.0) * 0.5 * count); }

PointOrder makeCellOrder(int resolution) {
  const int cells = resolution - 1;
  const std::vector<LocalPoint>& pattern = supportPattern().points;
  // points of one cell together: kernels load its nodes once for all of them
  std::vector<std::vector<int>> members(static_cast<size_t>(cells) * cells * cells);
  for (int p = 0; p < kSupportPointCount; ++p) {
    const LocalPoint& point = pattern[p];
    members[cellAlong(point[0], cells) + cells * (cellAlong(point[1], cells) + cells * cellAlong(point[2], cells))].push_back(p);
  }
  PointOrder order;
  order.resolution = resolution;
  std::vector<LocalPoint> points;
  for (size_t cell = 0; cell < members.size(); ++cell) {
    order.cell_begin.push_back(static_cast<int>(points.size()));
    for (const int p : members[cell]) {
      order.pattern_index.push_back(p);
      points.push_back(pattern[p]);
    }
    const int x = static_cast<int>(cell) % cells, y = static_cast<int>(cell) / cells % cells;
    const int z = static_cast<int>(cell) / (cells * cells);
    const auto centre = [cells](int i) { return static_cast<float>((2 * i + 1) / static_cast<double>(cells) - 1.0); };
    // vectors never span two cells: the gap is filled with the cell's centre, which has no index in the pattern
    while (points.size() % kPointGroup != 0) {
      order.pattern_index.push_back(-1);
      points.push_back({centre(x), centre(y), centre(z)});
    }
  }
  order.cell_begin.push_back(static_cast<int>(points.size()));
  // one minibatch of all points
  order.batch_begin = {0, static_cast<int>(points.size())};
  order.minibatch_places = static_cast<int>(points.size());
  order.points = makePointSet(points);
  order.points.count = kSupportPointCount;
  return order;
}

}  // namespace

const PointOrder& stratumOrder() {
  static const PointOrder order = makeStratumOrder();
  return order;
}

const PointOrder& cellOrder(int resolution) {
  static const std::array<PointOrder, 4> orders = {makeCellOrder(3), makeCellOrder(5), makeCellOrder(7), makeCellOrder(9)};
  return orders[(resolution - 3) / 2];
}

}  // namespace nlg
