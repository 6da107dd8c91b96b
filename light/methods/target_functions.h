// Blends by target φ itself, at places that are known beforehand: what functions would give if they were stored without error.
#pragma once

#include <unordered_map>
#include <vector>

#include "datagen/weighting/weighting_builder.h"
#include "light/methods/light_method.h"
#include "light/methods/probe_set.h"

namespace nlg {

class TargetFunctions : public Weighting {
 public:
  // Makes the function of every probe that a place reads.
  // places   relative to the scene's origin; blendAt knows these and no others
  TargetFunctions(const std::vector<glm::dvec3>& places, const ProbeSet& probes, const RayScene& rays, const LinkTable& links,
                  const DiffusionOptions& diffusion, int thread_count);
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  struct PlaceHash {
    size_t operator()(const glm::dvec3& place) const;
  };
  std::unordered_map<glm::dvec3, ProbeBlend, PlaceHash> blends_;
};

}  // namespace nlg
