#include "validate/light/neural/light_samples.h"

#include <algorithm>

#include "light/directions.h"
#include "tool/error.h"

namespace nlg {
namespace {

SampleBatch emptyBatch(int64_t count) { return {torch::empty({count, kSampleInputs}), torch::empty({count, kShChannels})}; }

}  // namespace

SampleFrame frameAround(const std::vector<glm::dvec3>& position_m) {
  SampleFrame frame;
  if (position_m.empty()) return frame;
  glm::dvec3 low = position_m.front(), high = low;
  for (const glm::dvec3& position : position_m) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  frame.middle_m = 0.5 * (low + high);
  const glm::dvec3 half = 0.5 * (high - low);
  frame.half_m = std::max({half.x, half.y, half.z, 1e-3});
  return frame;
}

LightSamples::LightSamples(const LitPlaces& lit, std::vector<uint32_t> learned, const std::vector<uint32_t>& held_out,
                           const SampleFrame& frame, float unit, uint64_t seed)
    : lit_(lit), learned_(std::move(learned)), frame_(frame), unit_(unit) {
  NLG_CHECK(learned_.size(), >, 0u);
  const std::vector<uint32_t>& places = held_out.empty() ? learned_ : held_out;
  const size_t count = std::min(places.size(), kMostHeldOut);
  held_out_ = emptyBatch(static_cast<int64_t>(count));
  Random random(seed);
  // evenly thinned out: they stand in the order of cells
  for (size_t i = 0; i < count; ++i) {
    fill(places[i * places.size() / count], &random, held_out_.input.data_ptr<float>() + i * kSampleInputs,
         held_out_.target.data_ptr<float>() + i * kShChannels);
  }
}

SampleBatch LightSamples::draw(int64_t count, Random* random) const {
  SampleBatch batch = emptyBatch(count);
  float* input = batch.input.data_ptr<float>();
  float* target = batch.target.data_ptr<float>();
  for (int64_t i = 0; i < count; ++i) {
    const uint32_t place = learned_[random->below(static_cast<uint32_t>(learned_.size()))];
    fill(place, random, input + i * kSampleInputs, target + i * kShChannels);
  }
  return batch;
}

void LightSamples::fill(uint32_t place, Random* random, float* input, float* target) const {
  const glm::vec3 position = frame_.inFrame(lit_.position_m[place]);
  const double u = random->uniform(), v = random->uniform();
  const glm::vec3 normal = sphereDirection(u, v);
  const glm::vec3 light = glm::max(irradiance(lit_.light[place], normal), glm::vec3(0.0f)) / unit_;
  for (int axis = 0; axis < 3; ++axis) {
    input[axis] = position[axis];
    input[3 + axis] = normal[axis];
    target[axis] = light[axis];
  }
}

}  // namespace nlg
