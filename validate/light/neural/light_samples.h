// What networks learn: pairs of a place with a normal, and the irradiance there.
#pragma once

#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "runtime_eval/numbers/random.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

// Positions as networks read them: within the cube they lie in [-1, 1]³.
struct SampleFrame {
  glm::dvec3 middle_m{0.0};
  double half_m = 1.0;  // > 0: half the cube's side

  glm::vec3 inFrame(const glm::dvec3& position_m) const { return glm::vec3((position_m - middle_m) / half_m); }
};
// The smallest cube around all places, by their middle.
SampleFrame frameAround(const std::vector<glm::dvec3>& position_m);

inline constexpr int64_t kSampleInputs = 6;  // position in the frame, normal

struct SampleBatch {
  torch::Tensor input;   // B x kSampleInputs
  torch::Tensor target;  // B x 3: irradiance over `unit`, >= 0
};

class LightSamples {
 public:
  // lit            must outlive this object
  // learned, held_out   of its places; learned not empty
  // unit           > 0: what irradiance is divided by
  LightSamples(const LitPlaces& lit, std::vector<uint32_t> learned, const std::vector<uint32_t>& held_out,
               const SampleFrame& frame, float unit, uint64_t seed);

  // Learned places by chance, each with a normal by chance.
  SampleBatch draw(int64_t count, Random* random) const;
  // Held-out places, or where there are none those that are learned from; kMostHeldOut of them at most, each with one normal.
  const SampleBatch& heldOut() const { return held_out_; }

  static constexpr size_t kMostHeldOut = 16384;

 private:
  void fill(uint32_t place, Random* random, float* input, float* target) const;

  const LitPlaces& lit_;
  const std::vector<uint32_t> learned_;
  const SampleFrame frame_;
  const float unit_;
  SampleBatch held_out_;
};

}  // namespace nlg
