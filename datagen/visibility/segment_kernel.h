// Vectorised segment tests: which links, and which rays from one point, meet which triangles.
//
// What counts as meeting is segmentMeets, a pure function of one segment and one triangle; everything here only leaves out pairs
// that it would say no to. The same bits on every SIMD target: no fused multiply-adds. Rules and figures: docs/theory/visibility.md.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "datagen/visibility/local_triangles.h"
#include "datagen/visibility/segment_packets.h"

namespace nlg {

// Does the segment meet the triangle? Its ends count, and so does the triangle's rim, widened by kEdgeReach; a segment that lies
// in the triangle's plane does not meet it. The same for (to, from).
bool segmentMeets(const LocalTriangle& triangle, const LocalPoint& from, const LocalPoint& to);

// Kept between probes so that none of them allocates.
struct LinkScratch {
  std::array<std::vector<uint32_t>, kLeafCount> triangles_of_leaf;
};

// Sets bit i of blocked[p] when the segment from the eye to the point at place 16 p + i meets a triangle.
// eye       local coordinates, in the support; the local origin is the probe
// blocked   a word a packet, all written
void blockRays(const PointPackets& points, const std::vector<LocalTriangle>& triangles, const LocalPoint& eye, uint16_t* blocked);

// Adds each triangle's index to the lists of the octants that it touches, or comes near; bits as in SupportPattern.
void sortIntoOctants(const std::vector<LocalTriangle>& triangles, std::array<std::vector<uint32_t>, kMirrorCount>* octants);

// The same of some of the triangles and the points of a cell, seen from a corner of it: bit i of blocked[p] is of its point 16 p + i.
// some      indices into triangles
// eye       local coordinates, anywhere
// blocked   kOctantPointCount / kPacketLanes words, all written
void blockOctantRays(const CornerPackets& points, const std::vector<LocalTriangle>& triangles, const std::vector<uint32_t>& some,
                     const LocalPoint& eye, uint16_t* blocked);

// Sets bit i of blocked[p] when the link at place 16 p + i meets a triangle.
// blocked   a word a packet, all written
void blockLinks(const LinkPackets& links, const std::vector<LocalTriangle>& triangles, LinkScratch* scratch, uint16_t* blocked);

}  // namespace nlg
