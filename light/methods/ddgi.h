// Dynamic diffuse global illumination for a static scene: Majercik and others, "Dynamic diffuse global illumination with
// ray-traced irradiance fields" (JCGT 2019), with the constants and shaders of RTXGI-DDGI 1.3.
//
// Each probe holds irradiance (6² texels, an exponent of 1/5) and two moments of depth (14² texels), octahedral. The weight of a
// probe is trilinear, times a soft test of the normal, times Chebyshev's bound on being seen. What differs from RTXGI:
// - Where RTXGI averages over frames, the rays of one bake are all averaged at once.
// - Probes are those of the tree that all methods share, not of a box full of them.
// - A probe of whose rays more than a tenth meet back faces is inactive; RTXGI would leave it black. Rays that meet back faces carry
//   what light the path tracer finds there; RTXGI leaves them out.
// - Sheets, faces of double-sided materials, have backs, as RTXGI goes by the hit alone: probes behind them are inactive. Where sheets
//   are not wound outward that leaves much of a room unlit; so there is the other rule, SheetBacks::none, too.
// - As shipped, irradiance is scaled so that the brightest texel is stored as 1, and the factor 1.0989, which makes up for what
//   averaging frames in 10 bits loses, is left out.
// - Relocation moves a probe off a surface by a third of the spacing at a time; RTXGI's step of 1 m is further than it lets a probe
//   go at spacings below 2.2 m, so that there most would stay where they are.
// - There is no camera, and no view bias. The .1 m of cornell.ini, laid along the normal, makes leak and most errors larger (house:3,
//   apartment:1, cornell).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/glm.hpp>

#include "light/methods/light_method.h"

namespace nlg {

// Functions of directions as square maps, by the octahedral mapping: the form in which DDGI stores irradiance and depth.
//
// A map of N x N texels; beyond its rim lies what the mapping says, as RTXGI's border texels have it. Cigolle and others, "A survey of
// efficient representations for independent unit vectors" (JCGT 2014).
//
// On [-1, 1]².
inline glm::vec2 octahedralPlace(const glm::vec3& direction) {
  const glm::vec3 d = direction / (std::fabs(direction.x) + std::fabs(direction.y) + std::fabs(direction.z));
  if (d.z >= 0.0f) return {d.x, d.y};
  return {std::copysign(1.0f - std::fabs(d.y), d.x), std::copysign(1.0f - std::fabs(d.x), d.y)};
}

inline glm::vec3 octahedralDirection(const glm::vec2& place) {
  glm::vec3 d(place.x, place.y, 1.0f - std::fabs(place.x) - std::fabs(place.y));
  if (d.z < 0.0f) {
    const glm::vec3 folded(std::copysign(1.0f - std::fabs(d.y), d.x), std::copysign(1.0f - std::fabs(d.x), d.y), d.z);
    d = folded;
  }
  return glm::normalize(d);
}

template <class Texel, int kSide>
struct OctahedralMap {
  static constexpr int kTexelCount = kSide * kSide;
  std::array<Texel, kTexelCount> texels{};

  // Of a texel's centre.
  static glm::vec3 direction(int texel) {
    const auto centre = [](int i) { return (2.0f * static_cast<float>(i) + 1.0f) / kSide - 1.0f; };
    return octahedralDirection({centre(texel % kSide), centre(texel / kSide)});
  }

  // x, y in [-1, kSide]
  const Texel& wrapped(int x, int y) const {
    if (x < 0 || x >= kSide) {
      x = x < 0 ? 0 : kSide - 1;
      y = kSide - 1 - y;
    }
    if (y < 0 || y >= kSide) {
      y = y < 0 ? 0 : kSide - 1;
      x = kSide - 1 - x;
    }
    return texels[y * kSide + x];
  }

  // Bilinear between texel centres.
  Texel at(const glm::vec3& direction) const {
    const glm::vec2 place = (octahedralPlace(direction) * 0.5f + 0.5f) * static_cast<float>(kSide) - 0.5f;
    const int x = std::clamp(static_cast<int>(std::floor(place.x)), -1, kSide - 1);
    const int y = std::clamp(static_cast<int>(std::floor(place.y)), -1, kSide - 1);
    const float sx = place.x - static_cast<float>(x), sy = place.y - static_cast<float>(y);
    return (wrapped(x, y) * (1.0f - sx) + wrapped(x + 1, y) * sx) * (1.0f - sy) +
           (wrapped(x, y + 1) * (1.0f - sx) + wrapped(x + 1, y + 1) * sx) * sy;
  }
};

// A probe, with borders: 1,288.
inline constexpr size_t kDdgiShippedDepthBytes = 16 * 16 * 4;
inline constexpr size_t kDdgiShippedBytes = 8 * 8 * 4 + kDdgiShippedDepthBytes + 4 * 2;

// Whether a ray that meets a double-sided face from behind has met a back.
enum class SheetBacks : uint8_t {
  as_wound,  // RTXGI's own rule
  none,      // such a face is a front from both sides
};

// Whether the two rules differ: a scene without double-sided faces knows one.
bool hasSheets(const Scene& scene);

struct DdgiMapsOptions {
  GatherOptions gather;  // its rays are cast for depth as well
  SheetBacks backs = SheetBacks::as_wound;
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
