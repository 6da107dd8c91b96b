// How light is asked for at points, of ground truth, a light grid or any other method; and what a method costs.
//
// Most methods blend what up to 8 probes hold. Their weights and the probes' light are told apart, so that every kind of weights can
// be tried with every kind of light.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "light/light_transport.h"
#include "nlg/look_up.h"

namespace nlg {

// Where light is asked for.
struct Receiver {
  glm::dvec3 position_m{0.0};  // relative to the scene's origin
  glm::vec3 normal{0.0f, 1.0f, 0.0f};
};

enum class Reach : uint8_t {
  lit,
  fallback,  // lit by what the method takes where its own weights say nothing, or by what is left of weights that nearly do
  unlit,     // no probe counts: black
  outside,   // of what the method covers: black, or what stands nearest
};

struct LightAnswer {
  glm::vec3 irradiance{0.0f};  // >= 0
  Reach reach = Reach::unlit;
  glm::vec3 deviation{0.0f};  // standard deviation of its noise, where any is known

  // false: no light is known there, and irradiance is 0
  bool isLit() const { return reach == Reach::lit || reach == Reach::fallback || irradiance != glm::vec3(0.0f); }
};

// Fills answers, as many as there are receivers; each is a function of its receiver alone, but for rounding. Any number of threads may
// ask at once.
using LightAt = std::function<void(std::span<const Receiver> receivers, LightAnswer* answers)>;

// Of a method that answers one receiver after another, by irradianceAt(position_m, normal).
// method   a pointer of any kind
template <class Pointer>
LightAt lightOf(Pointer method) {
  return [method = std::move(method)](std::span<const Receiver> receivers, LightAnswer* answers) {
    for (const Receiver& at : receivers) *answers++ = method->irradianceAt(at.position_m, at.normal);
  };
}

// Of one receiver, of many on several threads.
LightAnswer answerAt(const LightAt& light_at, const Receiver& receiver);
std::vector<LightAnswer> answersAt(const LightAt& light_at, const std::vector<Receiver>& receivers, int thread_count);

// Ground truth: gathered or path traced at every receiver by itself.
// transport   must outlive the result
LightAt trueLight(const LightTransport& transport, const GatherOptions& options, uint64_t seed);

// The shares of probes at a place.
struct ProbeBlend {
  std::array<uint32_t, 8> probe{};
  std::array<float, 8> weight{};  // of the first `count`, > 0; they sum to 1, or less where reach is fallback or outside
  int count = 0;                  // 0 … 8; > 0 where reach is lit or fallback, and perhaps outside
  float sum = 1.0f;               // of the weights that finish divided by it
  Reach reach = Reach::unlit;

  // Weights of 0 and below are left out.
  void add(uint32_t which, float its_weight) {
    if (!(its_weight > 0.0f)) return;
    probe[count] = which;
    weight[count++] = its_weight;
  }
  // Divides by the sum. Without weights the reach becomes unlit, otherwise `when_lit`.
  void finish(Reach when_lit);
};

class Weighting {
 public:
  virtual ~Weighting() = default;
  // position_m   relative to the scene's origin
  // normal       unit; many methods do not look at it
  // Any number of threads may ask at once.
  virtual ProbeBlend blendAt(const glm::dvec3& position_m, const glm::vec3& normal) const = 0;
  // The same before they are normalised, in shares of a tent: what light is solved with, which trusts a place the less the less
  // weight there is.
  virtual ProbeWeights weightsAt(const glm::dvec3& position_m, const glm::vec3& normal) const;
};

// What a method stores.
struct MethodBytes {
  size_t light = 0;    // of probes
  size_t weights = 0;  // what its weights are made of
  size_t tree = 0;     // where probes stand
  size_t total() const { return light + weights + tree; }
};

struct LightMethod {
  std::string weights;  // the method's name
  std::string light;    // "point": gathered where the probe stands; "solved"; "own": in the method's own form
  LightAt light_at;
  const Weighting* weighting = nullptr;  // of those that blend probes
  MethodBytes bytes;
  size_t probes = 0;                                  // that bytes are stored of
  double weights_s = 0.0, light_s = 0.0;              // of its bake: of the processor, summed over threads
  const std::vector<LightSh>* probe_light = nullptr;  // of those that blend harmonics, by probe
};

// What a blend of probes that hold spherical harmonics answers. Both must outlive it.
LightAt blendedLight(const Weighting& weighting, const std::vector<LightSh>& light);

// The probes that all methods share: where they stand, which of them stand in air, and what light arrives there.
struct ProbeSetOptions {
  GatherOptions gather;
  int thread_count = 1;
  uint64_t seed = 1;
};

struct ProbeSet {
  ProbeTree tree;  // in the scene's coordinates, as positions are
  std::vector<glm::dvec3> position_m;
  std::vector<float> spacing_m;
  std::vector<uint8_t> is_in_air;
  std::vector<LightSh> light;  // gathered where each stands, in solid too
  size_t air_count = 0;
  double gather_s = 0.0;  // of the processor, summed over threads

  size_t count() const { return position_m.size(); }
};

ProbeSet makeProbeSet(const ProbeTree& tree, const LightTransport& transport, const ProbeSetOptions& options);

// Where a position lies in its cell, shares of its side along each axis, in [0, 1].
glm::dvec3 placeInCell(const ProbeTree& tree, const ProbeCell& cell, const glm::dvec3& position_m);

}  // namespace nlg
