// Dynamic diffuse global illumination for a scene that stands still: Majercik and others, "Dynamic diffuse global illumination with
// ray-traced irradiance fields" (JCGT 2019), with the constants and shaders of RTXGI-DDGI 1.3.
//
// Each probe holds irradiance (6² texels, an exponent of 1/5) and two moments of depth (14² texels), octahedral. The weight of a
// probe is trilinear, times a soft test of the normal, times Chebyshev's bound on being seen. What differs from RTXGI:
// - Where RTXGI averages over frames, the rays of one bake are all averaged at once.
// - Probes are those of the tree that all methods share, not of a box full of them.
// - A probe of whose rays more than a tenth meet back faces is inactive; RTXGI would leave it black.
// - As shipped, irradiance is scaled so that the brightest texel is stored as 1, and the factor 1.0989, which makes up for what
//   averaging frames in 10 bits loses, is left out.
// - Relocation moves a probe off a surface by a third of the spacing at a time; RTXGI's step of 1 m is further than it lets a probe
//   go at spacings below 2.2 m, so that there most would stay where they are.
// - There is no camera, and no view bias: the .1 m of cornell.ini, laid along the normal, made leak and most errors larger in the
//   three scenes that were tried (house:3, apartment:1, cornell).
#pragma once

#include "light/methods/light_method.h"
#include "light/methods/octahedral_map.h"
#include "light/methods/probe_set.h"

namespace nlg {

// A probe, with borders: 1,288.
inline constexpr size_t kDdgiShippedDepthBytes = 16 * 16 * 4;
inline constexpr size_t kDdgiShippedBytes = 8 * 8 * 4 + kDdgiShippedDepthBytes + 4 * 2;

struct DdgiMapsOptions {
  GatherOptions gather;  // its rays are cast for depth as well
  bool relocates = false;
  int thread_count = 1;
  uint64_t seed = 1;
};

struct DdgiProbe {
  glm::dvec3 position_m{0.0};  // relocated, if so
  bool is_active = false;
  OctahedralMap<glm::vec3, 6> irradiance;  // over 2 pi, to the power of 1/5
  OctahedralMap<glm::vec2, 14> depth;      // mean and mean square, metres; from the probe
};

struct DdgiMaps {
  std::vector<DdgiProbe> probes;
  float scale = 1.0f;   // irradiance over what is stored
  double bake_s = 0.0;  // of the processor, summed over threads
};

DdgiMaps makeDdgiMaps(const ProbeSet& probes, const LightTransport& transport, const DdgiMapsOptions& options);

// What is left of maps in RTXGI's formats: irradiance in 10 bits, depth in float16.
DdgiMaps asShipped(DdgiMaps maps);

class Ddgi : public Weighting {
 public:
  // Both must outlive this object.
  Ddgi(const ProbeSet& probes, const DdgiMaps& maps) : probes_(probes), maps_(maps) {}

  ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const override;
  // From its own maps: square roots of irradiance are blended.
  LightAnswer irradianceAt(const glm::dvec3& position_m, const glm::vec3& normal) const;

  // The weight of one probe as RTXGI has it, but for the trilinear one, before the blend.
  // biased_m   the place moved off its surface
  float probeWeight(const DdgiProbe& probe, const glm::dvec3& position_m, const glm::dvec3& biased_m,
                    const glm::vec3& normal) const;

 private:
  float chebyshev(const DdgiProbe& probe, const glm::dvec3& biased_m) const;

  const ProbeSet& probes_;
  const DdgiMaps& maps_;
};

}  // namespace nlg
