#include "runtime_eval/light_grid/light_grid.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "runtime_eval/evaluator/brick_quads.h"
#include "runtime_eval/evaluator/evaluate_point.h"

namespace nlg {
namespace {

FileResult refuse(FileStatus status, std::string detail) { return {status, std::move(detail)}; }

std::string sized(const char* what, size_t size, const char* expected, size_t count) {
  return std::string(what) + " has " + std::to_string(size) + " entries; expected " + expected + ": " + std::to_string(count);
}

FileResult checkRepresentations(const LightGrid& grid) {
  const size_t count = grid.representations.size();
  if (count > kMaxGridRepresentations)
    return refuse(FileStatus::value_out_of_range, std::to_string(count) + " representations; expected at most 256");
  for (size_t i = 0; i < count; ++i) {
    const Representation& representation = grid.representations[i];
    const std::string place = "representation " + std::to_string(i);
    Representation known;
    if (!findRepresentation(representationName(representation), &known))
      return refuse(FileStatus::value_out_of_range, place + ": expected " + representationNames());
    if (representation.isNetwork() && !(representation.slope > 0.0f && representation.slope < 1.0f))
      return refuse(FileStatus::value_out_of_range, place + ": slope lies outside (0, 1)");
  }
  return {};
}

FileResult checkDictionaries(const LightGrid& grid) {
  for (size_t i = 0; i < grid.representations.size(); ++i) {
    const Representation& representation = grid.representations[i];
    if (!representation.isCode()) continue;
    const std::string place = "representation " + std::to_string(i);
    if (representation.dictionary == nullptr)
      return refuse(FileStatus::value_out_of_range, place + ": a code without a dictionary");
    if (representation.dictionary->codeCount() != representation.code_count ||
        representation.dictionary->resolution() != representation.resolution)
      return refuse(FileStatus::value_out_of_range, place + ": a dictionary of other codes");
  }
  return {};
}

FileResult checkFunctions(const LightGrid& grid) {
  const size_t count = grid.functionCount();
  if (count > kMaxGridFunctions) return refuse(FileStatus::value_out_of_range, std::to_string(count) + " functions");
  if (grid.theta_begin.size() != count + 1)
    return refuse(FileStatus::tensor_unexpected, sized("theta_begin", grid.theta_begin.size(), "functions + 1", count + 1));
  uint64_t begin = 0;
  for (size_t function = 0; function < count; ++function) {
    const std::string place = "function " + std::to_string(function);
    if (grid.function_representation[function] >= grid.representations.size())
      return refuse(FileStatus::value_out_of_range, place + ": representation does not exist");
    if (grid.theta_begin[function] != begin) return refuse(FileStatus::value_out_of_range, place + ": theta_begin");
    begin += static_cast<uint64_t>(grid.representations[grid.function_representation[function]].thetaCount());
  }
  if (grid.theta_begin[count] != begin) return refuse(FileStatus::value_out_of_range, "theta_begin: its last entry");
  if (grid.theta.size() != begin)
    return refuse(FileStatus::tensor_unexpected, sized("theta", grid.theta.size(), "what its functions need", begin));
  return {};
}

FileResult checkBricks(const LightGrid& grid) {
  const size_t count = grid.functionCount();
  if (grid.function_brick.size() != count)
    return refuse(FileStatus::tensor_unexpected, sized("function_brick", grid.function_brick.size(), "functions", count));
  uint64_t begin = 0;
  for (size_t function = 0; function < count; ++function) {
    const Representation& representation = grid.representations[grid.function_representation[function]];
    const FunctionBrick& brick = grid.function_brick[function];
    const bool has_brick =
        brick.step > 0.0f && std::isfinite(brick.step) && brick.begin == begin && brick.resolution == representation.resolution;
    if (has_brick != representation.isCode()) {
      return refuse(FileStatus::value_out_of_range,
                    "function " + std::to_string(function) + ": its brick; makeBricks makes bricks");
    }
    if (has_brick) begin += quadCount(representation.resolution);
  }
  if (grid.quads.size() != begin)
    return refuse(FileStatus::tensor_unexpected, sized("quads", grid.quads.size(), "what its codes need", begin));
  return {};
}

// Adds the brick of the next function.
void addBrick(const Representation& representation, const float* theta, LightGrid* grid) {
  FunctionBrick& brick = grid->function_brick.emplace_back();
  if (!representation.isCode() || representation.dictionary == nullptr) return;
  for (int k = 0; k < representation.code_count; ++k) {
    if (!(std::abs(theta[k]) <= kMaxGridTheta)) return;
  }
  int8_t nodes[kMaxBrickNodes];
  brick.begin = grid->quads.size();
  brick.resolution = representation.resolution;
  brick.step = packBrick(*representation.dictionary, theta, nodes);
  grid->quads.resize(brick.begin + quadCount(representation.resolution));
  packQuads(representation.resolution, nodes, &grid->quads[brick.begin]);
}

FileResult checkValues(const char* name, const std::vector<float>& values, float most) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::abs(values[i]) <= most) continue;
    const bool finite = std::isfinite(values[i]);
    return refuse(finite ? FileStatus::value_out_of_range : FileStatus::value_not_finite,
                  std::string(name) + ": value " + std::to_string(i));
  }
  return {};
}

// False where the weight counts as none.
bool addWeight(uint32_t probe, float weight, ProbeWeights* weights) {
  if (!(weight >= kLeastWeight)) return false;
  weights->probe[weights->count] = probe;
  weights->weight[weights->count++] = weight;
  return true;
}

}  // namespace

double intensityThatFits(double largest) { return std::pow(10.0, std::floor(std::log10(kMaxEngineLight / largest))); }

uint32_t LightGrid::addFunction(uint8_t representation, const float* theta_D) {
  theta.insert(theta.end(), theta_D, theta_D + representations[representation].thetaCount());
  theta_begin.push_back(theta.size());
  function_representation.push_back(representation);
  addBrick(representations[representation], theta_D, this);
  return static_cast<uint32_t>(functionCount() - 1);
}

void LightGrid::makeBricks() {
  function_brick.clear();
  quads.clear();
  size_t size = 0;
  for (const uint8_t r : function_representation)
    size += representations[r].isCode() ? quadCount(representations[r].resolution) : 0;
  quads.reserve(size);
  function_brick.reserve(functionCount());
  for (size_t f = 0; f < functionCount(); ++f) addBrick(representations[function_representation[f]], functionTheta(f), this);
}

FileResult checkLightGrid(const LightGrid& grid) {
  FileResult result = checkWithoutBricks(grid);
  return result.ok() ? checkBricks(grid) : result;
}

FileResult checkWithoutBricks(const LightGrid& grid) {
  const size_t probes = grid.tree.probeCount();
  if (grid.probe_function.size() != probes)
    return refuse(FileStatus::tensor_unexpected, sized("probe_function", grid.probe_function.size(), "probes", probes));
  FileResult result = checkRepresentations(grid);
  if (result.ok()) result = checkFunctions(grid);
  if (result.ok()) result = checkDictionaries(grid);
  if (!result.ok()) return result;
  for (size_t probe = 0; probe < probes; ++probe) {
    const uint32_t function = grid.probe_function[probe];
    if (function < grid.functionCount() || function == kFreeSpace || function == kNoWeight) continue;
    return refuse(FileStatus::value_out_of_range, "probe " + std::to_string(probe) + ": function " + std::to_string(function) +
                                                      " of " + std::to_string(grid.functionCount()));
  }
  if (!grid.light.empty() && grid.light.size() != probes * kShFloats)
    return refuse(FileStatus::tensor_unexpected, sized("light", grid.light.size(), "27 a probe", probes * kShFloats));
  result = checkValues("theta", grid.theta, kMaxGridTheta);
  return result.ok() ? checkLight(grid.light) : result;
}

LightPacking roundGridLight(double max_error, LightGrid* grid) {
  std::vector<float> light;
  for (size_t probe = 0; probe < grid->probe_function.size(); ++probe) {
    if (grid->probe_function[probe] != kNoWeight)
      light.insert(light.end(), grid->probeLight(probe), grid->probeLight(probe) + kShFloats);
  }
  const LightPacking packing = packLight(light, max_error, &grid->packed_light);
  unpackGridLight(grid->packed_light, grid->probe_function, &grid->light);
  return packing;
}

bool holdsPackedLight(const LightGrid& grid) {
  std::vector<float> light;
  return unpackGridLight(grid.packed_light, grid.probe_function, &light).ok() && light == grid.light;
}

PackedLight packedLightOf(const LightGrid& grid, double max_error) {
  if (holdsPackedLight(grid)) return grid.packed_light;
  LightGrid rounded;
  rounded.probe_function = grid.probe_function;
  rounded.light = grid.light;
  roundGridLight(max_error, &rounded);
  return std::move(rounded.packed_light);
}

FileResult unpackGridLight(const PackedLight& packed, const std::vector<uint32_t>& probe_function, std::vector<float>* light) {
  const auto with_weight =
      probe_function.size() - static_cast<size_t>(std::count(probe_function.begin(), probe_function.end(), kNoWeight));
  std::vector<float> of_weighted;
  light->clear();
  FileResult result = unpackLight(packed, with_weight, &of_weighted);
  if (!result.ok()) return result;
  light->resize(probe_function.size() * kShFloats);
  auto next = of_weighted.begin();
  for (size_t probe = 0; probe < probe_function.size(); ++probe) {
    if (probe_function[probe] == kNoWeight) continue;
    std::copy_n(next, kShFloats, light->begin() + static_cast<ptrdiff_t>(probe * kShFloats));
    next += kShFloats;
  }
  return {};
}

FileResult checkLight(const std::vector<float>& light) { return checkValues("light", light, kMaxGridLight); }

void weightsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights) {
  constexpr float kStretch = 1.0f / (1.0f - kResidue);
  static_assert((1.0f - kResidue) * kStretch == 1.0f, "bare tents would not keep all");
  weights->count = 0;
  float sum = 0.0f, believed = 0.0f;
  for (const ProbeAround& corner : around.corners) {
    const uint32_t function = grid.probe_function[corner.probe];
    if (function == kNoWeight) continue;
    const float bare = tent(corner.local);
    float share = 1.0f;
    if (function != kFreeSpace) {
      const Representation& representation = grid.representations[grid.function_representation[function]];
      share = representation.isCode() ? evaluateQuads(representation.resolution, corner.local, grid.function_brick[function].step,
                                                      grid.functionQuads(function))
                                      : evaluateTentShare(representation, corner.local, bare, grid.functionTheta(function));
    }
    const float above = share - kResidue;
    const float weight = bare * corner.tent_ratio * (above * kStretch);
    if (!addWeight(corner.probe, weight, weights)) continue;
    sum += weight;
    believed += weight * above;
  }
  weights->certainty = sum > 0.0f ? std::min(1.0f, believed / (kResidue * sum)) : 0.0f;
}

void tentsAround(const LightGrid& grid, const ProbesAround& around, ProbeWeights* weights) {
  weights->count = 0;
  weights->certainty = 1.0f;
  for (const ProbeAround& corner : around.corners) {
    if (grid.probe_function[corner.probe] == kNoWeight) continue;
    addWeight(corner.probe, tent(corner.local) * corner.tent_ratio, weights);
  }
}

bool lookUpWeights(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights) {
  ProbesAround around;
  if (!grid.tree.lookUp(position_m, &around)) return false;
  weightsAround(grid, around, weights);
  return true;
}

bool lookUpTents(const LightGrid& grid, const PositionM& position_m, ProbeWeights* weights) {
  ProbesAround around;
  if (!grid.tree.lookUp(position_m, &around)) return false;
  tentsAround(grid, around, weights);
  return true;
}

bool normaliseWeights(ProbeWeights* weights) {
  if (weights->count == 0) return false;
  float sum = 0.0f;
  for (int i = 0; i < weights->count; ++i) sum += weights->weight[i];
  const float scale = weights->certainty / sum;
  for (int i = 0; i < weights->count; ++i) weights->weight[i] *= scale;
  return true;
}

}  // namespace nlg
