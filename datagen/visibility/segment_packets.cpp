#include "datagen/visibility/segment_packets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace nlg {
namespace {

constexpr float kFar = 1e30f;

LocalPoint centerOf(const ItemBox& box) {
  return {0.5f * (box.low[0] + box.high[0]), 0.5f * (box.low[1] + box.high[1]), 0.5f * (box.low[2] + box.high[2])};
}

void grow(ItemBox& box, const ItemBox& by) {
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::min(box.low[axis], by.low[axis]);
    box.high[axis] = std::max(box.high[axis], by.high[axis]);
  }
}

const ItemBox kNothing = {{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};

class TreeBuilder {
 public:
  TreeBuilder(const std::vector<ItemBox>& items, PacketTree* tree) : items_(items), tree_(*tree) {
    tree_.order.resize(items.size());
    std::iota(tree_.order.begin(), tree_.order.end(), 0u);
    const auto packet_count = static_cast<uint32_t>((items.size() + kPacketLanes - 1) / kPacketLanes);
    tree_.nodes.resize(kNodeCount + kPacketLanes);
    tree_.packets.resize(packet_count + kPacketLanes);
    // outwards rounding of this box leaves it where no triangle of a support reaches
    for (uint32_t i = packet_count; i < packet_count + kPacketLanes; ++i)
      tree_.packets.set(i, {kFar, kFar, kFar}, {kFar, kFar, kFar});
  }

  void build() {
    const auto packet_count = static_cast<uint32_t>((items_.size() + kPacketLanes - 1) / kPacketLanes);
    split(0, packet_count, 0, 0);
    tree_.first_packet[kLeafCount] = packet_count;
    tree_.order.resize(packet_count * kPacketLanes, tree_.order.back());
  }

 private:
  // Orders packets [begin, end) of a node; `depth` counts binary splits, three of which are one level; `path` is the node's index
  // among those of its depth. Returns the box around it all.
  ItemBox split(uint32_t begin, uint32_t end, int depth, uint32_t path) {
    if (depth == 3 * kTreeLevels) {
      tree_.first_packet[path] = begin;
      return setNode(depth, path, splitLeaf(begin, end));
    }
    const uint32_t middle = begin + (end - begin + 1) / 2;
    divide(begin, middle, end);
    ItemBox box = split(begin, middle, depth + 1, 2 * path);
    grow(box, split(middle, end, depth + 1, 2 * path + 1));
    return depth % 3 == 0 && depth > 0 ? setNode(depth, path, box) : box;
  }

  ItemBox splitLeaf(uint32_t begin, uint32_t end) {
    if (begin == end) return kNothing;
    if (end - begin > 1) {
      const uint32_t middle = begin + (end - begin) / 2;
      divide(begin, middle, end);
      ItemBox box = splitLeaf(begin, middle);
      grow(box, splitLeaf(middle, end));
      return box;
    }
    // halves are the same whatever the library's order inside them; this makes packets the same
    std::sort(tree_.order.begin() + begin * kPacketLanes, tree_.order.begin() + static_cast<ptrdiff_t>(lastItem(end)));
    const ItemBox box = boxOf(begin, end);
    tree_.packets.set(begin, box.low, box.high);
    return box;
  }

  ItemBox setNode(int depth, uint32_t path, const ItemBox& box) {
    constexpr int kFirstOfLevel[] = {0, 0, 8, kFirstLeaf};
    const size_t node = kFirstOfLevel[depth / 3] + path;
    if (box.low[0] > box.high[0]) {
      tree_.nodes.set(node, {kFar, kFar, kFar}, {kFar, kFar, kFar});
    } else {
      tree_.nodes.set(node, box.low, box.high);
    }
    return box;
  }

  ItemBox boxOf(uint32_t begin, uint32_t end) const {
    ItemBox box = kNothing;
    for (size_t i = begin * kPacketLanes; i < lastItem(end); ++i) grow(box, items_[tree_.order[i]]);
    return box;
  }

  // Puts the items of smaller centres along the widest axis into packets [begin, middle); of equal ones those of lower index.
  void divide(uint32_t begin, uint32_t middle, uint32_t end) {
    if (begin == end || lastItem(middle) == lastItem(end)) return;
    ItemBox centers = kNothing;
    for (size_t i = begin * kPacketLanes; i < lastItem(end); ++i) {
      const LocalPoint center = centerOf(items_[tree_.order[i]]);
      grow(centers, {center, center});
    }
    int widest = 0;
    for (int axis = 1; axis < 3; ++axis) {
      if (centers.high[axis] - centers.low[axis] > centers.high[widest] - centers.low[widest]) widest = axis;
    }
    const auto at = [&](size_t item) { return tree_.order.begin() + static_cast<ptrdiff_t>(item); };
    std::nth_element(at(begin * kPacketLanes), at(lastItem(middle)), at(lastItem(end)), [&](uint32_t a, uint32_t b) {
      const float ca = centerOf(items_[a])[widest], cb = centerOf(items_[b])[widest];
      return ca != cb ? ca < cb : a < b;
    });
  }

  // Only the very last packet may hold fewer items than lanes.
  size_t lastItem(uint32_t end_packet) const { return std::min<size_t>(size_t{end_packet} * kPacketLanes, items_.size()); }

  const std::vector<ItemBox>& items_;
  PacketTree& tree_;
};

std::array<AlignedFloats, 3> gather(const std::vector<LocalPoint>& points, const std::vector<uint32_t>& order) {
  std::array<AlignedFloats, 3> gathered;
  for (int axis = 0; axis < 3; ++axis) {
    gathered[axis].reserve(order.size());
    for (const uint32_t point : order) gathered[axis].push_back(points[point][axis]);
  }
  return gathered;
}

}  // namespace

void Boxes::resize(size_t count) {
  for (int axis = 0; axis < 3; ++axis) {
    center[axis].resize(count);
    extent[axis].resize(count);
  }
}

void Boxes::set(size_t index, const LocalPoint& low, const LocalPoint& high) {
  for (int axis = 0; axis < 3; ++axis) {
    center[axis][index] = 0.5f * (low[axis] + high[axis]);
    const float half = std::max(high[axis] - center[axis][index], center[axis][index] - low[axis]);
    extent[axis][index] = std::nextafter(half, std::numeric_limits<float>::infinity());
  }
}

PacketTree makePacketTree(const std::vector<ItemBox>& items) {
  PacketTree tree;
  TreeBuilder(items, &tree).build();
  return tree;
}

LinkPackets makeLinkPackets(const std::vector<LocalPoint>& points, const std::vector<uint64_t>& pairs) {
  std::vector<ItemBox> boxes;
  boxes.reserve(pairs.size());
  for (const uint64_t pair : pairs) {
    const LocalPoint &a = points[pair >> 32], &b = points[static_cast<uint32_t>(pair)];
    ItemBox box;
    for (int axis = 0; axis < 3; ++axis) std::tie(box.low[axis], box.high[axis]) = std::minmax(a[axis], b[axis]);
    boxes.push_back(box);
  }
  LinkPackets packets;
  packets.tree = makePacketTree(boxes);
  for (const uint32_t item : packets.tree.order) {
    packets.from_point.push_back(static_cast<uint32_t>(pairs[item] >> 32));
    packets.to_point.push_back(static_cast<uint32_t>(pairs[item]));
  }
  packets.from = gather(points, packets.from_point);
  packets.to = gather(points, packets.to_point);
  return packets;
}

PointPackets makePointPackets(const std::vector<LocalPoint>& points) {
  std::vector<ItemBox> boxes;
  for (const LocalPoint& point : points) boxes.push_back({point, point});
  PointPackets packets;
  packets.tree = makePacketTree(boxes);
  packets.at = gather(points, packets.tree.order);
  return packets;
}

const PointPackets& supportPackets() {
  static const PointPackets packets = makePointPackets(supportPattern().points);
  return packets;
}

CornerPackets makeCornerPackets(int corner, PointChoice choice) {
  const uint32_t point_count = choice == PointChoice::all ? kOctantPointCount : kOctantSampleCount;
  CornerPackets cell;
  cell.packet_count = point_count / kPacketLanes;
  const uint32_t filled = std::max<uint32_t>(cell.packet_count, kPacketLanes);
  cell.packets.resize(filled);
  for (uint32_t packet = 0; packet < filled; ++packet) {
    LocalPoint low{1, 1, 1}, high{-1, -1, -1};
    for (uint32_t i = packet * kPacketLanes; i < (packet + 1) * kPacketLanes; ++i) {
      const uint32_t point = choice == PointChoice::all ? i : octantSamples()[i % point_count];
      for (int axis = 0; axis < 3; ++axis) {
        const float x = supportPattern().points[point][axis] - static_cast<float>(corner >> axis & 1);
        low[axis] = std::min(low[axis], x);
        high[axis] = std::max(high[axis], x);
        cell.at[axis].push_back(x);
      }
    }
    cell.packets.set(packet, low, high);
  }
  return cell;
}

}  // namespace nlg
