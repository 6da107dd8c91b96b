#include "validate/light/neural/lit_places.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "light/surface_cache.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr uint64_t kMorePlacesStream = 0x6d6f7265, kMoreLightStream = 0x6c69676874, kSplitStream = 0x73706c6974;
constexpr float kDarkest = 1e-6f;  // a unit for scenes without light
constexpr int kDrawsPerPlace = 4;  // as a bake has it

}  // namespace

LitPlaces drawLitPlaces(const LightTransport& transport, const ProbeTree& tree, const AirPlaces& own,
                        const std::vector<LightSh>& light, const ProbeLightOptions& solve, int times, int thread_count) {
  LitPlaces lit{own.places, light};
  if (times == 1) return lit;
  const auto start = std::chrono::steady_clock::now();
  uint32_t most = 0;
  for (const AirPlaces::Cell& cell : own.cells) most = std::max(most, cell.count);
  AirPlaceOptions draw;
  draw.places_per_cell = static_cast<int>(most) * (times - 1);
  draw.draws_per_cell = kDrawsPerPlace * draw.places_per_cell;
  draw.seed = mixSeed(solve.seed, kMorePlacesStream);
  const std::vector<glm::dvec3> more = findAirPlaces(transport.rays(), tree, draw, thread_count).places;
  ProbeLightOptions of_more = solve;
  of_more.seed = mixSeed(solve.seed, kMoreLightStream);
  const std::unique_ptr<SurfaceCache> cache = makeSurfaceCache(transport, more, tree.frame().spacing_m, of_more, thread_count);
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

}  // namespace nlg
