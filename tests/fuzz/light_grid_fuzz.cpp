// Hostile light grids for libFuzzer: whatever the bytes, the reader answers with a status and a reason, or with a grid in which
// look-ups stay inside and which can be written again. Start from the files of light_grid_seeds, or most inputs end in the
// header:
//
//     light_grid_seeds SEEDS && light_grid_fuzz -max_len=9000 CORPUS SEEDS
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "runtime_eval/light_grid/light_grid_file.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

#define FUZZ_CHECK(condition, text) \
  ((condition) ? void() : (std::fprintf(stderr, "%s does not hold: %s\n", #condition, std::string(text).c_str()), std::abort()))

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

void readOne(std::string_view bytes) {
  LightGrid grid;
  GridMetadata metadata;
  WeightsResult result = parseLightGrid(bytes, &grid, &metadata);
  FUZZ_CHECK(result.ok() == result.detail.empty(), result.detail);
  if (!result.ok()) return;
  result = checkLightGrid(grid);
  FUZZ_CHECK(result.ok(), result.detail);
  lookUpEverywhere(grid);
  std::string again;
  result = serializeLightGrid(grid, {ThetaPrecision::float32, LightForm::sh2_float16}, metadata, &again);
  FUZZ_CHECK(result.ok(), result.detail);
}

}  // namespace
}  // namespace nlg

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  nlg::readOne({reinterpret_cast<const char*>(data), size});
  return 0;
}
