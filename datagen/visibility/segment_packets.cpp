#include "datagen/visibility/segment_packets.h"

#include <algorithm>
#include <tuple>

namespace nlg {
namespace {

std::array<AlignedFloats, 3> gather(const std::vector<LocalPoint>& points, const std::vector<uint32_t>& order) {
  std::array<AlignedFloats, 3> gathered;
  for (int axis = 0; axis < 3; ++axis) {
    gathered[axis].reserve(order.size());
    for (const uint32_t point : order) gathered[axis].push_back(points[point][axis]);
  }
  return gathered;
}

}  // namespace

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
