#include "validate/light/neural/lit_places.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "light/directions.h"
#include "light/surface_cache.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kMorePlacesStream = 0x6d6f7265, kMoreLightStream = 0x6c69676874, kSplitStream = 0x73706c6974;
constexpr float kDarkest = 1e-6f;  // a unit for scenes without light
constexpr int kDrawsPerPlace = 4;  // as a bake has it

SampleBatch emptyBatch(int64_t count) { return {torch::empty({count, kSampleInputs}), torch::empty({count, kShChannels})}; }

}  // namespace

LitPlaces drawLitPlaces(const LightTransport& transport, const ProbeTree& tree, const AirPlaces& own,
                        const std::vector<LightSh>& light, const ProbeLightOptions& solve, int times, int thread_count) {
  LitPlaces lit{own.places, light};
  if (times == 1) return lit;
  // as many more places as asked, drawn in the bake's cells by the bake's own rule
  const auto start = std::chrono::steady_clock::now();
  uint32_t most = 0;
  for (const AirPlaces::Cell& cell : own.cells) most = std::max(most, cell.count);
  AirPlaceOptions draw;
  draw.places_per_cell = static_cast<int>(most) * (times - 1);
  draw.draws_per_cell = kDrawsPerPlace * draw.places_per_cell;
  draw.seed = mixSeed(solve.seed, kMorePlacesStream);
  const std::vector<glm::dvec3> more = findAirPlaces(transport.rays(), tree, draw, thread_count).places;
  // measured as the bake measures its own: the same rays, and bounces from a cache of their own
  ProbeLightOptions of_more = solve;
  of_more.seed = mixSeed(solve.seed, kMoreLightStream);
  const std::unique_ptr<SurfaceCache> cache = makeSurfaceCache(transport, more, own.spacing_m, of_more, thread_count);
  of_more.place.cache = cache.get();
  const std::vector<LightSh> measured = measureLight(transport, more, of_more.place, of_more.seed, thread_count);
  lit.position_m.insert(lit.position_m.end(), more.begin(), more.end());
  lit.light.insert(lit.light.end(), measured.begin(), measured.end());
  lit.measure_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return lit;
}

float meanIrradiance(const std::vector<LightSh>& light) {
  // over all normals nothing is left but the first coefficient
  const float band = kCosineBand[0] * shBasis(0.0f, 0.0f, 1.0f)[0];
  double sum = 0.0;
  for (const LightSh& sh : light) sum += band * (sh[0].r + sh[0].g + sh[0].b) / kShChannels;
  return std::max(kDarkest, static_cast<float>(sum / std::max<double>(1.0, static_cast<double>(light.size()))));
}

PlaceSplit splitPlaces(size_t count, uint64_t seed) {
  PlaceSplit split;
  for (uint32_t i = 0; i < count; ++i)
    (mixSeed(seed, kSplitStream, i) % kHeldOutShare == 0 ? split.held_out : split.learned).push_back(i);
  return split;
}

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
