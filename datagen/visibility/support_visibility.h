// What an eye sees of a probe's support.
//
// A probe sees what its eye sees: its own place, or for a probe in solid a place in air (solid_eye.h). Only the triangles that touch the
// support are looked at, in its local coordinates, through a fixed hierarchy over its points (segment_kernel.h). What cells make of it:
// probe_lattice.h, docs/theory/visibility.md.
#pragma once

#include <cstdint>
#include <vector>

#include "datagen/visibility/local_triangles.h"
#include "datagen/visibility/ray_scene.h"
#include "datagen/visibility/segment_packets.h"

namespace nlg {

class SupportVisibility {
 public:
  // The scene must outlive this object. One object serves many probes, one after another.
  explicit SupportVisibility(const RayScene& scene);

  // Moves to another probe, forgets everything about the last, and collects the triangles of the support.
  // position_m   relative to the scene's origin; spacing_m > 0
  void beginProbe(const glm::dvec3& position_m, float spacing_m);

  const RayScene& rays() const { return scene_; }
  const std::vector<LocalTriangle>& triangles() const { return triangles_; }  // that touch the support
  glm::dvec3 placeOf(const LocalPoint& local) const;                          // relative to the scene's origin

  // Which points are seen from an eye: a place of the support, local coordinates.
  void traceRays(const LocalPoint& eye);
  const LocalPoint& eye() const { return eye_; }  // of the rays that were traced last
  // Calls visit(point) for every support point that it does not see, in no particular order.
  template <class Visit>
  void forEachDark(const Visit& visit) const {
    const uint32_t* order = supportPackets().tree.order.data();
    for (size_t packet = 0; packet < blocked_.size(); ++packet) {
      for (uint32_t lanes = blocked_[packet]; lanes != 0; lanes &= lanes - 1)
        visit(order[packet * kPacketLanes + static_cast<size_t>(__builtin_ctz(lanes))]);
    }
  }

  // Whether no triangle of the support meets a segment in it, local coordinates: the rule of all rays and links, one at a time.
  bool isOpen(const LocalPoint& from, const LocalPoint& to) const;

 private:
  const RayScene& scene_;
  glm::dvec3 position_{0.0};
  double spacing_ = 1.0;
  LocalPoint eye_{};
  std::vector<uint16_t> blocked_;  // by packet of points
  // kept between probes so that none of them allocates
  std::vector<uint32_t> candidates_;
  std::vector<LocalTriangle> triangles_;
};

}  // namespace nlg
