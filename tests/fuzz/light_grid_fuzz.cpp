// Hostile light grids: whatever the bytes, the reader answers with a status and a reason, or with a grid in which look-ups stay
// inside and which can be written again.
#include <cmath>
#include <string>
#include <string_view>

#include "nlg/look_up.h"
#include "tests/fuzz/digests.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {
namespace {

void lookUpEverywhere(const LightGrid& grid) {
  const ProbeTreeFrame& frame = grid.tree.frame();
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    PositionM position_m;
    for (int axis = 0; axis < 3; ++axis)
      position_m[axis] = frame.first_m[axis] + frame.spacing_m * kRootSide * frame.root_count[axis] * random.uniform();
    ProbeWeights weights;
    if (!lookUpWeights(grid, position_m, &weights)) continue;
    for (int k = 0; k < weights.count; ++k) {
      FUZZ_CHECK(weights.probe[k] < grid.tree.probeCount(), std::to_string(weights.probe[k]));
      FUZZ_CHECK(weights.weight[k] >= kLeastWeight && weights.weight[k] <= 1.0f, std::to_string(weights.weight[k]));
    }
  }
}

void lightEverywhere(const LightGrid& grid) {
  const ProbeTreeFrame& frame = grid.tree.frame();
  Random random(2);
  for (int i = 0; i < 40; ++i) {
    PositionM position_m;
    float normal[3], rgb[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double along = kRootSide * frame.root_count[axis] * random.uniform(-0.05, 1.05);
      position_m[axis] = frame.first_m[axis] + frame.spacing_m * along;
      normal[axis] = static_cast<float>(random.uniform(-1.0, 1.0));
    }
    lookUpIrradiance(grid, position_m, normal, rgb);
    for (const float value : rgb) FUZZ_CHECK(std::isfinite(value) && value >= 0.0f, std::to_string(value));
  }
}

}  // namespace

void readOne(std::string_view bytes) {
  LightGrid grid;
  GridMetadata metadata;
  const std::string file = withRightDigest(std::string(bytes));
  // a string may own more than its text: a read past the end shall leave the allocation
  const std::vector<char> exact(file.begin(), file.end());
  FileResult result = parseLightGrid({exact.data(), exact.size()}, &grid, &metadata);
  FUZZ_CHECK(result.ok() || !result.detail.empty(), "a reason");
  if (!result.ok()) return;
  result = checkLightGrid(grid);
  FUZZ_CHECK(result.ok(), result.detail);
  lookUpEverywhere(grid);
  lightEverywhere(grid);
  std::string again;
  result = serializeLightGrid(grid, {ThetaPrecision::float32}, metadata, &again);
  FUZZ_CHECK(result.ok(), result.detail);
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
