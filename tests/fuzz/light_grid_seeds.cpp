// The files that light_grid_fuzz starts from: small grids with trees of one, two and three levels, without light and with light in
// every form.
#include <string>

#include "nlg/light_grid.h"
#include "runtime_eval/evaluator/kernel_shape.h"
#include "tests/fuzz/fuzz.h"
#include "tests/runtime_eval/sample_dictionary.h"

namespace nlg::fuzz {
namespace {

// Too coarse around one point down to cells of `finest` units, nothing in the upper half.
CellJudge aroundOnePoint(int32_t finest) {
  return [finest](const ProbeCell& cell) {
    bool holds_point = true;
    for (const int32_t low : cell.low) holds_point = holds_point && low <= 5 && 5 < low + cell.side;
    if (holds_point && cell.side > finest) return CellVerdict::too_coarse;
    return cell.low[2] < 32 ? CellVerdict::fits : CellVerdict::unneeded;
  };
}

LightGrid smallGrid(int32_t finest) {
  LightGrid grid;
  ProbeTree::build({{0.0, 1.0, 2.0}, 0.5, {1, 1, 1}}, aroundOnePoint(finest), kMaxTreeProbes, &grid.tree);
  grid.representations = {Representation::mlp(), Representation::productField(3),
                          Representation::code(sampleDictionary(3, 16, 1))};
  const std::vector<float> theta(kMaxThetaCount, 0.25f);
  Random random(1);
  const uint32_t choices[] = {grid.addFunction(0, theta.data()),
                              grid.addFunction(1, theta.data()),
                              grid.addFunction(2, sampleCode(*grid.representations[2].dictionary, 16, random).data()),
                              grid.addFunction(2, sampleCode(*grid.representations[2].dictionary, 8, random).data()),
                              kFreeSpace,
                              kNoWeight};
  for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) grid.probe_function.push_back(choices[probe % 6]);
  for (size_t i = 0; i < grid.tree.probeCount() * kShFloats; ++i) grid.light.push_back(0.01f * static_cast<float>(i % 101));
  return grid;
}

}  // namespace

Seeds seeds() {
  Seeds seeds;
  for (const int32_t finest : {32, 8, 2}) {
    LightGrid grid = smallGrid(finest);
    // one light, then two groups, then four of which some begin dark
    for (int32_t g = 0; g < 16 / finest && finest < 32; g += finest == 8 ? 1 : 2)
      grid.groups.push_back({"group " + std::to_string(g), grid.light, g > 3});
    if (!grid.groups.empty()) FUZZ_CHECK(mixLight(startingColours(grid), &grid).ok(), "groups");
    const std::string name = std::to_string(finest);
    const GridPrecision precisions[] = {
        {ThetaPrecision::float32, std::nullopt}, {ThetaPrecision::int8, 0.02}, {ThetaPrecision::float16, 0.2}};
    for (const GridPrecision& precision : precisions) {
      std::string bytes;
      FUZZ_CHECK(serializeLightGrid(grid, precision, {{"scene", "house"}}, &bytes).ok(), name);
      seeds.emplace_back(name + "_" + std::to_string(static_cast<int>(precision.theta)), bytes);
    }
  }
  return seeds;
}

}  // namespace nlg::fuzz
