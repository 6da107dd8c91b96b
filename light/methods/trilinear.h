// Trilinear blends of the 8 probes around a place: of all, of those in air, of those that see the place.
#pragma once

#include "datagen/visibility/ray_scene.h"
#include "light/methods/light_method.h"
#include "light/methods/probe_set.h"

namespace nlg {

enum class TrilinearKind {
  all,      // whatever the probe stands in
  valid,    // probes in air; places around which none is are unlit
  visible,  // probes in air that the place sees, by a ray each: what no stored form does better with these shares. Where it sees
            // none, those in air
};

class Trilinear : public Weighting {
 public:
  // Both must outlive this object.
  Trilinear(TrilinearKind kind, const ProbeSet& probes, const RayScene& rays) : kind_(kind), probes_(probes), rays_(rays) {}
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  const TrilinearKind kind_;
  const ProbeSet& probes_;
  const RayScene& rays_;
};

}  // namespace nlg
