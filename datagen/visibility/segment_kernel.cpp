#include "datagen/visibility/segment_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "datagen/visibility/segment_kernel.cpp"
#include <hwy/foreach_target.h>
// after foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kPacketLanes>;
using Floats = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;

// Three coordinates in every lane.
struct Vectors {
  Floats x, y, z;
};

HWY_INLINE Floats dot(const Vectors& a, const Vectors& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

HWY_INLINE Vectors broadcast(const float* vector) {
  const Tag d;
  return {hn::Set(d, vector[0]), hn::Set(d, vector[1]), hn::Set(d, vector[2])};
}

HWY_INLINE Vectors load(const std::array<AlignedFloats, 3>& arrays, size_t first) {
  const Tag d;
  return {hn::LoadU(d, &arrays[0][first]), hn::LoadU(d, &arrays[1][first]), hn::LoadU(d, &arrays[2][first])};
}

HWY_INLINE Vectors abs(const Vectors& v) { return {hn::Abs(v.x), hn::Abs(v.y), hn::Abs(v.z)}; }

HWY_INLINE uint32_t bits(Mask mask) {
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(Tag(), mask, bytes);
  uint32_t result;
  std::memcpy(&result, bytes, sizeof(result));
  return result;
}

// A triangle in every lane.
struct WideTriangle {
  explicit HWY_INLINE WideTriangle(const LocalTriangle& t)
      : normal(broadcast(t.normal)),
        outward{broadcast(t.outward[0]), broadcast(t.outward[1]), broadcast(t.outward[2])},
        center(broadcast(t.center)),
        extent(broadcast(t.extent)),
        offset(hn::Set(Tag(), t.offset)),
        reach{hn::Set(Tag(), t.reach[0]), hn::Set(Tag(), t.reach[1]), hn::Set(Tag(), t.reach[2])} {}

  // The boxes from `first` on that come within kBoxMargin of the triangle: separating axes of the box's faces, the triangle's
  // plane, and its edges within the plane.
  HWY_INLINE uint32_t touches(const Boxes& boxes, size_t first) const {
    const Tag d;
    const Floats margin = hn::Set(d, kBoxMargin);
    const Vectors at = load(boxes.center, first), half = load(boxes.extent, first);
    Mask near = hn::Le(hn::Abs(hn::Sub(at.x, center.x)), hn::Add(hn::Add(half.x, extent.x), margin));
    near = hn::And(near, hn::Le(hn::Abs(hn::Sub(at.y, center.y)), hn::Add(hn::Add(half.y, extent.y), margin)));
    near = hn::And(near, hn::Le(hn::Abs(hn::Sub(at.z, center.z)), hn::Add(hn::Add(half.z, extent.z), margin)));
    if (hn::AllFalse(d, near)) return 0;
    const Floats distance = hn::Abs(hn::Sub(dot(normal, at), offset));
    near = hn::And(near, hn::Le(distance, hn::Add(dot(abs(normal), half), margin)));
    if (hn::AllFalse(d, near)) return 0;
    for (int e = 0; e < 3; ++e) {
      const Floats beyond = hn::Sub(hn::Sub(dot(outward[e], at), reach[e]), dot(abs(outward[e]), half));
      near = hn::And(near, hn::Le(beyond, margin));
    }
    return bits(near);
  }

  // segmentMeets, a segment a lane.
  HWY_INLINE uint32_t meets(const Vectors& from, const Vectors& to) const {
    const Tag d;
    const Floats zero = hn::Zero(d);
    const Floats from_side = hn::Sub(dot(normal, from), offset);
    const Floats to_side = hn::Sub(dot(normal, to), offset);
    Mask met =
        hn::Or(hn::And(hn::Ge(from_side, zero), hn::Le(to_side, zero)), hn::And(hn::Le(from_side, zero), hn::Ge(to_side, zero)));
    met = hn::And(met, hn::Ne(from_side, to_side));
    if (hn::AllFalse(d, met)) return 0;
    // where it crosses the plane, times `scale`
    const Floats from_share = hn::Abs(to_side), to_share = hn::Abs(from_side), scale = hn::Add(from_share, to_share);
    const Vectors at = {hn::Add(hn::Mul(from.x, from_share), hn::Mul(to.x, to_share)),
                        hn::Add(hn::Mul(from.y, from_share), hn::Mul(to.y, to_share)),
                        hn::Add(hn::Mul(from.z, from_share), hn::Mul(to.z, to_share))};
    for (int e = 0; e < 3; ++e) met = hn::And(met, hn::Le(dot(outward[e], at), hn::Mul(reach[e], scale)));
    if (hn::AllFalse(d, met)) return 0;
    met = hn::And(met, hn::Le(hn::Abs(hn::Sub(at.x, hn::Mul(center.x, scale))), hn::Mul(extent.x, scale)));
    met = hn::And(met, hn::Le(hn::Abs(hn::Sub(at.y, hn::Mul(center.y, scale))), hn::Mul(extent.y, scale)));
    met = hn::And(met, hn::Le(hn::Abs(hn::Sub(at.z, hn::Mul(center.z, scale))), hn::Mul(extent.z, scale)));
    return bits(met);
  }

  Vectors normal, outward[3], center, extent;
  Floats offset, reach[3];
};

constexpr uint32_t kAllLanes = (1u << kPacketLanes) - 1;
constexpr uint32_t kAllChildren = (1u << kTreeWidth) - 1;

// Calls visit(i) for the set bits, lowest first.
template <class Visit>
HWY_INLINE void forEachBit(uint32_t word, const Visit& visit) {
  for (; word != 0; word &= word - 1) visit(static_cast<uint32_t>(__builtin_ctz(word)));
}

HWY_INLINE uint32_t touchingChildren(const WideTriangle& triangle, const Boxes& nodes, size_t first) {
  uint32_t touched = 0;
  for (size_t i = 0; i < kTreeWidth; i += hn::Lanes(Tag())) touched |= triangle.touches(nodes, first + i) << i;
  return touched & kAllChildren;
}

void sortIntoLeaves(const PacketTree& tree, const std::vector<LocalTriangle>& triangles,
                    std::array<std::vector<uint32_t>, kLeafCount>* leaves) {
  for (std::vector<uint32_t>& list : *leaves) list.clear();
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const WideTriangle triangle(triangles[t]);
    forEachBit(touchingChildren(triangle, tree.nodes, 0), [&](uint32_t i) {
      forEachBit(touchingChildren(triangle, tree.nodes, kTreeWidth * (i + 1)), [&](uint32_t j) {
        const uint32_t node = kTreeWidth * (i + 1) + j, first_leaf = kTreeWidth * (node + 1);
        forEachBit(touchingChildren(triangle, tree.nodes, first_leaf),
                   [&](uint32_t k) { (*leaves)[first_leaf - kFirstLeaf + k].push_back(t); });
      });
    });
  }
}

void blockLinksVectors(const LinkPackets& links, const std::vector<LocalTriangle>& triangles, LinkScratch* scratch,
                       uint16_t* HWY_RESTRICT blocked) {
  const PacketTree& tree = links.tree;
  std::fill(blocked, blocked + tree.packetCount(), uint16_t{0});
  const size_t lanes = hn::Lanes(Tag());
  const auto testPackets = [&](const WideTriangle& triangle, uint32_t first, uint32_t end) {
    // boxes of packets, a vector of them at a time; lanes past the end are of other packets
    for (uint32_t begin = first; begin < end; begin += static_cast<uint32_t>(lanes)) {
      uint32_t touched = triangle.touches(tree.packets, begin);
      if (end - begin < lanes) touched &= (1u << (end - begin)) - 1;
      forEachBit(touched, [&](uint32_t i) {
        const uint32_t packet = begin + i;
        // a packet whose 16 links are all blocked has nothing left to learn
        if (blocked[packet] == kAllLanes) return;
        uint32_t met = 0;
        for (size_t k = 0; k < kPacketLanes; k += lanes) {
          const size_t place = size_t{packet} * kPacketLanes + k;
          met |= triangle.meets(load(links.from, place), load(links.to, place)) << k;
        }
        blocked[packet] |= static_cast<uint16_t>(met);
      });
    }
  };
  // fewer packets than leaves: their boxes alone leave out as much as the tree would
  if (tree.packetCount() <= kLeafCount) {
    for (const LocalTriangle& triangle : triangles)
      testPackets(WideTriangle(triangle), 0, static_cast<uint32_t>(tree.packetCount()));
    return;
  }
  // triangles descend the tree once; leaves then run over theirs, so that a leaf's packets stay in cache
  sortIntoLeaves(tree, triangles, &scratch->triangles_of_leaf);
  for (uint32_t leaf = 0; leaf < kLeafCount; ++leaf) {
    for (const uint32_t t : scratch->triangles_of_leaf[leaf])
      testPackets(WideTriangle(triangles[t]), tree.first_packet[leaf], tree.first_packet[leaf + 1]);
  }
}

// Scalars, in the order in which segmentMeets and WideTriangle compute them.
HWY_INLINE float dot(const float* a, const LocalPoint& b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }
HWY_INLINE float absoluteDot(const float* a, const LocalPoint& b) {
  return std::fabs(a[0] * b[0]) + std::fabs(a[1] * b[1]) + std::fabs(a[2] * b[2]);
}

// The shadow of a triangle, seen from the eye: four half-spaces. Linear in the point, so that boxes can be told to lie wholly
// outside or wholly inside.
struct Shadow {
  HWY_INLINE Shadow(const LocalTriangle& t, const LocalPoint& eye) {
    const float eye_side = dot(t.normal, eye) - t.offset;
    const float sign = eye_side > 0.0f ? -1.0f : 1.0f, distance = std::fabs(eye_side);
    // behind the plane: sign · (normal · x - offset) > 0
    float plane[4][3], limit[4], margin[4];
    for (int axis = 0; axis < 3; ++axis) plane[3][axis] = -sign * t.normal[axis];
    limit[3] = -sign * t.offset;
    margin[3] = kBoxMargin;
    // inside the edges: the crossing is (eye · sign · (normal · x - offset) + x · distance) over the sum of the two
    for (int e = 0; e < 3; ++e) {
      const float eye_reach = t.reach[e] - dot(t.outward[e], eye);
      for (int axis = 0; axis < 3; ++axis) plane[e][axis] = distance * t.outward[e][axis] - eye_reach * sign * t.normal[axis];
      limit[e] = distance * t.reach[e] - eye_reach * sign * t.offset;
      margin[e] = kBoxMargin * (distance + std::fabs(t.reach[e]) + absoluteDot(t.outward[e], eye));
    }
    // a plane through the very eye is met on both sides: nothing is left out
    const float unknown = distance == 0.0f ? std::numeric_limits<float>::infinity() : 0.0f;
    for (int h = 0; h < 4; ++h) {
      half_space[h] = broadcast(plane[h]);
      outside[h] = hn::Set(Tag(), limit[h] + margin[h] + unknown);
      inside[h] = hn::Set(Tag(), limit[h] - margin[h] - unknown);
    }
  }

  // Boxes from `first` on: `some` may hold points in the shadow, `all` hold no other.
  HWY_INLINE void judge(const Boxes& boxes, size_t first, uint32_t* some, uint32_t* all) const {
    const Tag d;
    const Vectors at = load(boxes.center, first), half = load(boxes.extent, first);
    Mask may = hn::MaskFromVec(hn::Zero(d)), must = may;
    for (int h = 0; h < 4; ++h) {
      const Floats middle = dot(half_space[h], at), spread = dot(abs(half_space[h]), half);
      const Mask may_h = hn::Le(hn::Sub(middle, spread), outside[h]), must_h = hn::Le(hn::Add(middle, spread), inside[h]);
      may = h == 0 ? may_h : hn::And(may, may_h);
      must = h == 0 ? must_h : hn::And(must, must_h);
    }
    *some = bits(may);
    *all = bits(must);
  }

  Vectors half_space[4];
  Floats outside[4], inside[4];
};

void blockRaysVectors(const PointPackets& points, const std::vector<LocalTriangle>& triangles, const LocalPoint& eye,
                      uint16_t* HWY_RESTRICT blocked) {
  const PacketTree& tree = points.tree;
  const Vectors from = broadcast(eye.data());
  std::fill(blocked, blocked + tree.packetCount(), uint16_t{0});
  const size_t lanes = hn::Lanes(Tag());
  // a subtree wholly in the shadow is blocked without a test
  const auto blockAll = [&](uint32_t first_leaf, uint32_t leaf_count) {
    std::fill(blocked + tree.first_packet[first_leaf], blocked + tree.first_packet[first_leaf + leaf_count], uint16_t{kAllLanes});
  };
  for (const LocalTriangle& local : triangles) {
    const WideTriangle triangle(local);
    const Shadow shadow(local, eye);
    // children in the shadow as a whole, and those that reach into it
    const auto judgeChildren = [&](size_t first, uint32_t* some, uint32_t* all) {
      *some = *all = 0;
      for (size_t i = 0; i < kTreeWidth; i += lanes) {
        uint32_t some_lanes, all_lanes;
        shadow.judge(tree.nodes, first + i, &some_lanes, &all_lanes);
        *some |= some_lanes << i;
        *all |= all_lanes << i;
      }
      *some &= kAllChildren & ~*all;
      *all &= kAllChildren;
    };
    const auto testLeaf = [&](uint32_t leaf) {
      for (uint32_t packet = tree.first_packet[leaf]; packet < tree.first_packet[leaf + 1]; ++packet) {
        if (blocked[packet] == kAllLanes) continue;
        uint32_t met = 0;
        for (size_t k = 0; k < kPacketLanes; k += lanes) {
          met |= triangle.meets(from, load(points.at, size_t{packet} * kPacketLanes + k)) << k;
        }
        blocked[packet] |= static_cast<uint16_t>(met);
      }
    };
    // three levels by hand: 64 leaves below a child of the root, 8 below its children
    uint32_t some, all;
    judgeChildren(0, &some, &all);
    forEachBit(all, [&](uint32_t i) { blockAll(64 * i, 64); });
    forEachBit(some, [&](uint32_t i) {
      uint32_t some_inner, all_inner;
      judgeChildren(kTreeWidth * (i + 1), &some_inner, &all_inner);
      forEachBit(all_inner, [&](uint32_t j) { blockAll(64 * i + 8 * j, 8); });
      forEachBit(some_inner, [&](uint32_t j) {
        const uint32_t first_leaf = 64 * i + 8 * j;
        uint32_t some_leaves, all_leaves;
        judgeChildren(kFirstLeaf + first_leaf, &some_leaves, &all_leaves);
        forEachBit(all_leaves, [&](uint32_t k) { blockAll(first_leaf + k, 1); });
        forEachBit(some_leaves, [&](uint32_t k) { testLeaf(first_leaf + k); });
      });
    });
  }
}

void sortIntoOctantsVectors(const Boxes& boxes, const std::vector<LocalTriangle>& triangles,
                            std::array<std::vector<uint32_t>, kMirrorCount>* octants) {
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    forEachBit(touchingChildren(WideTriangle(triangles[t]), boxes, 0), [&](uint32_t i) { (*octants)[i].push_back(t); });
  }
}

void blockOctantVectors(const CornerPackets& points, const std::vector<LocalTriangle>& triangles,
                        const std::vector<uint32_t>& some, const LocalPoint& eye, uint16_t* HWY_RESTRICT blocked) {
  const Vectors from = broadcast(eye.data());
  std::fill(blocked, blocked + points.packets.center[0].size(), uint16_t{0});
  const auto lanes = static_cast<uint32_t>(hn::Lanes(Tag()));
  // as blockRaysVectors, but for the points of one octant: so few that their packets need no tree
  for (const uint32_t t : some) {
    const WideTriangle triangle(triangles[t]);
    const Shadow shadow(triangles[t], eye);
    for (uint32_t first = 0; first < points.packet_count; first += lanes) {
      uint32_t may, must;
      shadow.judge(points.packets, first, &may, &must);
      forEachBit(must, [&](uint32_t i) { blocked[first + i] = kAllLanes; });
      forEachBit(may & ~must, [&](uint32_t i) {
        const uint32_t packet = first + i;
        if (blocked[packet] == kAllLanes) return;
        uint32_t met = 0;
        for (uint32_t k = 0; k < kPacketLanes; k += lanes)
          met |= triangle.meets(from, load(points.at, size_t{packet} * kPacketLanes + k)) << k;
        blocked[packet] |= static_cast<uint16_t>(met);
      });
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace nlg {

HWY_EXPORT(blockRaysVectors);
HWY_EXPORT(blockLinksVectors);
HWY_EXPORT(blockOctantVectors);
HWY_EXPORT(sortIntoOctantsVectors);

bool segmentMeets(const LocalTriangle& triangle, const LocalPoint& from, const LocalPoint& to) {
  const auto dot = [](const float* a, const LocalPoint& b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; };
  const float from_side = dot(triangle.normal, from) - triangle.offset, to_side = dot(triangle.normal, to) - triangle.offset;
  const bool crosses = (from_side >= 0 && to_side <= 0) || (from_side <= 0 && to_side >= 0);
  if (!crosses || from_side == to_side) return false;
  const float from_share = std::fabs(to_side), to_share = std::fabs(from_side), scale = from_share + to_share;
  LocalPoint at;  // where it crosses the plane, times scale
  for (int axis = 0; axis < 3; ++axis) at[axis] = from[axis] * from_share + to[axis] * to_share;
  for (int e = 0; e < 3; ++e) {
    if (dot(triangle.outward[e], at) > triangle.reach[e] * scale) return false;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (std::fabs(at[axis] - triangle.center[axis] * scale) > triangle.extent[axis] * scale) return false;
  }
  return true;
}

void blockRays(const PointPackets& points, const std::vector<LocalTriangle>& triangles, const LocalPoint& eye,
               uint16_t* blocked) {
  HWY_DYNAMIC_DISPATCH(blockRaysVectors)(points, triangles, eye, blocked);
}

void sortIntoOctants(const std::vector<LocalTriangle>& triangles, std::array<std::vector<uint32_t>, kMirrorCount>* octants) {
  static_assert(kMirrorCount == kTreeWidth);
  static const Boxes boxes = [] {
    Boxes all;
    all.resize(kPacketLanes);  // whole vectors
    for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
      LocalPoint low, high;
      for (int axis = 0; axis < 3; ++axis) low[axis] = mirror >> axis & 1 ? -1.0f : 0.0f, high[axis] = low[axis] + 1.0f;
      all.set(static_cast<size_t>(mirror), low, high);
    }
    return all;
  }();
  HWY_DYNAMIC_DISPATCH(sortIntoOctantsVectors)(boxes, triangles, octants);
}

void blockOctantRays(const CornerPackets& points, const std::vector<LocalTriangle>& triangles, const std::vector<uint32_t>& some,
                     const LocalPoint& eye, uint16_t* blocked) {
  HWY_DYNAMIC_DISPATCH(blockOctantVectors)(points, triangles, some, eye, blocked);
}

void blockLinks(const LinkPackets& links, const std::vector<LocalTriangle>& triangles, LinkScratch* scratch, uint16_t* blocked) {
  HWY_DYNAMIC_DISPATCH(blockLinksVectors)(links, triangles, scratch, blocked);
}

}  // namespace nlg
#endif  // HWY_ONCE
