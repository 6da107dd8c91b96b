// Sample points in air with their measured light, from which methods learn a scene's light.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <torch/types.h>
#include <glm/glm.hpp>

#include "light/air_places.h"
#include "light/light_transport.h"
#include "light/methods/light_method.h"
#include "light/probe_light.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {

struct LitPlaces {
  std::vector<glm::dvec3> position_m;  // relative to the scene's origin
  std::vector<LightSh> light;          // by place
  double measure_s = 0.0;              // by the clock, of those beyond the bake's own
};

// A bake's own places, and others that are drawn and measured as the bake does it, with another seed.
//
// tree         in the scene's coordinates: the cells that places are drawn in
// own, light   the bake's, and what it measured there
// solve        how it measured
// times        >= 1: how many times as many places as the bake has there should be in all
// The same for any number of threads.
LitPlaces drawLitPlaces(const LightTransport& transport, const ProbeTree& tree, const AirPlaces& own,
                        const std::vector<LightSh>& light, const ProbeLightOptions& solve, int times, int thread_count);

// Irradiance, its mean over all normals and channels, of the mean place: the unit in which networks answer. > 0.
float meanIrradiance(const std::vector<LightSh>& light);

// Which places are learned from, and by which it is told when to stop: one in kHeldOutShare.
inline constexpr uint64_t kHeldOutShare = 16;
struct PlaceSplit {
  std::vector<uint32_t> learned, held_out;  // indices, rising
};
PlaceSplit splitPlaces(size_t count, uint64_t seed);

// What networks learn: pairs of a place with a normal, and the irradiance there.
//
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

// What a method that learns a scene's light leaves behind, and what it cost.
//
// Words are of 32 bits; a look-up's own inputs and its places on a tree's way down are not among them.
struct LearnedCost {
  size_t parameters = 0;      // numbers that are stored
  size_t multiply_adds = 0;   // of a look-up
  size_t words_by_place = 0;  // that it reads from where its place says: scattered over memory
  size_t words_shared = 0;    // that every look-up reads
  size_t networks = 0;        // 0 of a tree
  size_t places = 0;          // that were learned from, held-out ones not among them
  size_t steps = 0;           // of training, over all networks
  size_t clamped = 0;         // numbers beyond float16
  double training_s = 0.0;    // processor seconds, threads summed
};

struct LearnedLight {
  LightAt light_at;  // owns what it reads
  MethodBytes bytes;
  LearnedCost cost;
};

// Bytes of a number in every network and table, and how many are a word.
inline constexpr size_t kLearnedBytes = 2, kLearnedInWord = 2;

}  // namespace nlg
