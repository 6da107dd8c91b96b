#include "datagen/visibility/packet_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

std::vector<ItemBox> randomItems(size_t count, uint64_t seed) {
  Random random(seed);
  std::vector<ItemBox> items(count);
  for (ItemBox& item : items) {
    for (int axis = 0; axis < 3; ++axis) {
      item.low[axis] = static_cast<float>(random.uniform(-1, 1));
      item.high[axis] = item.low[axis] + static_cast<float>(random.uniform(0, 0.2));
    }
  }
  return items;
}

bool holds(const Boxes& boxes, size_t box, const ItemBox& item) {
  for (int axis = 0; axis < 3; ++axis) {
    if (item.low[axis] < boxes.center[axis][box] - boxes.extent[axis][box]) return false;
    if (item.high[axis] > boxes.center[axis][box] + boxes.extent[axis][box]) return false;
  }
  return true;
}

TEST(PacketTree, OrdersEveryItemOnceAndFillsTheLastPacket) {
  for (const size_t count : {1, 15, 16, 17, 1000, 8192, 20011}) {
    const PacketTree tree = makePacketTree(randomItems(count, 1));
    ASSERT_EQ(tree.packetCount(), (count + 15) / 16);
    std::vector<uint32_t> sorted(tree.order.begin(), tree.order.begin() + count);
    for (size_t i = count; i < tree.order.size(); ++i) ASSERT_EQ(tree.order[i], tree.order[count - 1]);
    std::sort(sorted.begin(), sorted.end());
    for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(sorted[i], i) << count << " items";
  }
}

TEST(PacketTree, BoxesHoldWhatIsBelowThem) {
  for (const size_t count : {1, 100, 8192, 20011}) {
    const std::vector<ItemBox> items = randomItems(count, 2);
    const PacketTree tree = makePacketTree(items);
    ASSERT_EQ(tree.first_packet[0], 0u);
    ASSERT_EQ(tree.first_packet[kLeafCount], tree.packetCount());
    for (uint32_t leaf = 0; leaf < kLeafCount; ++leaf) {
      for (uint32_t packet = tree.first_packet[leaf]; packet < tree.first_packet[leaf + 1]; ++packet) {
        for (uint32_t i = 0; i < kPacketLanes; ++i) {
          const ItemBox& item = items[tree.order[packet * kPacketLanes + i]];
          ASSERT_TRUE(holds(tree.packets, packet, item)) << count << " items, packet " << packet;
          ASSERT_TRUE(holds(tree.nodes, kFirstLeaf + leaf, item)) << count << " items, leaf " << leaf;
          ASSERT_TRUE(holds(tree.nodes, 8 + leaf / 8, item)) << count << " items, leaf " << leaf;
          ASSERT_TRUE(holds(tree.nodes, leaf / 64, item)) << count << " items, leaf " << leaf;
        }
      }
    }
  }
}

}  // namespace
}  // namespace nlg
