// Unity's Adaptive Probe Volumes, after its manual and shaders: validity, virtual offset, dilation.
//
// A probe in geometry captures light a little outside of it (virtual offset); one that still meets back faces with more than a
// quarter of its rays is invalid, and takes its light from valid ones nearby (dilation). A look-up blends the valid ones of the
// eight probes around, by a mask of 8 bits; at a position that is moved along the normal. Where none is valid it blends them all.
// Not taken over: the view bias, since there is no camera, sampling noise, and that one texture fetch cannot give every combination
// of weights.
#pragma once

#include "light/methods/light_method.h"

namespace nlg {

inline constexpr size_t kApvBytes = 33;  // a probe, of order 2: L0 in float16, other bands in bytes, the mask

struct ApvProbes {
  std::vector<uint8_t> is_valid;  // by probe
  std::vector<LightSh> light;     // captured, or dilated
  double bake_s = 0.0;            // of the processor, summed over threads
};

ApvProbes bakeApvProbes(const ProbeSet& probes, const LightTransport& transport, const ProbeSetOptions& options);

class Apv : public Weighting {
 public:
  // Both must outlive this object.
  Apv(const ProbeSet& probes, const ApvProbes& baked) : probes_(probes), baked_(baked) {}
  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;

 private:
  const ProbeSet& probes_;
  const ApvProbes& baked_;
};

}  // namespace nlg
