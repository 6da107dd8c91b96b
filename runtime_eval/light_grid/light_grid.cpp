
#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/light_grid/packed_light.h"

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
      return refuse(FileStatus::value_out_of_range, place + ": a dictionary that does not fit its codes");
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

FileResult checkGroups(const LightGrid& grid) {
  if (grid.groups.size() > kMaxLightGroups)
    return refuse(FileStatus::value_out_of_range, std::to_string(grid.groups.size()) + " groups of light; expected at most 16");
  for (size_t g = 0; g < grid.groups.size(); ++g) {
    const LightGroup& group = grid.groups[g];
    const std::string place = "group of light " + std::to_string(g);
    const auto isControl = [](unsigned char c) { return c < ' '; };
    if (group.name.empty() || std::any_of(group.name.begin(), group.name.end(), isControl))
      return refuse(FileStatus::value_out_of_range, place + ": expected a name without control characters");
    if (std::any_of(&grid.groups[0], &grid.groups[g], [&](const LightGroup& other) { return other.name == group.name; }))
      return refuse(FileStatus::value_out_of_range, place + ": two groups have its name");
    if (group.light.size() != grid.light.size())
      return refuse(FileStatus::tensor_unexpected, sized(place.c_str(), group.light.size(), "as all light", grid.light.size()));
    FileResult result = checkValues(place.c_str(), group.light, kMaxGridLight);
    if (!result.ok()) return result;
  }
  return {};
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

void LightGrid::dropUnusedFunctions() {
  LightGrid kept;
  std::vector<uint32_t> function_now(functionCount(), kNoWeight);
  std::vector<int> representation_now(representations.size(), -1);
  // functions in the order of the probes that have them first: a file then names most of them as the next one
  for (uint32_t& function : probe_function) {
    if (function == kFreeSpace || function == kNoWeight) continue;
    if (function_now[function] == kNoWeight) {
      int& representation = representation_now[function_representation[function]];
      if (representation < 0) {
        representation = static_cast<int>(kept.representations.size());
        kept.representations.push_back(representations[function_representation[function]]);
      }
      function_now[function] = kept.addFunction(static_cast<uint8_t>(representation), functionTheta(function));
    }
    function = function_now[function];
  }
  representations = std::move(kept.representations);
  function_representation = std::move(kept.function_representation);
  theta_begin = std::move(kept.theta_begin);
  theta = std::move(kept.theta);
  function_brick = std::move(kept.function_brick);
  quads = std::move(kept.quads);
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
  // each check relies on those before it
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
  if (result.ok()) result = checkLight(grid.light);
  return result.ok() ? checkGroups(grid) : result;
}

namespace {

PackedLight packedAnew(const LightGrid& grid, double max_error, LightPacking* packing) {
  std::vector<float> light;
  for (const std::vector<float>* of_group : lightByGroup(grid)) {
    for (size_t probe = 0; probe < grid.probe_function.size(); ++probe) {
      const auto first = of_group->begin() + static_cast<ptrdiff_t>(probe * kShFloats);
      if (grid.probe_function[probe] != kNoWeight) light.insert(light.end(), first, first + kShFloats);
    }
  }
  PackedLight packed;
  *packing = packLight(light, max_error, &packed);
  return packed;
}

}  // namespace

std::vector<const std::vector<float>*> lightByGroup(const LightGrid& grid) {
  if (grid.groups.empty()) return {&grid.light};
  std::vector<const std::vector<float>*> light;
  for (const LightGroup& group : grid.groups) light.push_back(&group.light);
  return light;
}

std::vector<std::array<float, 3>> startingColours(const LightGrid& grid) {
  std::vector<std::array<float, 3>> colours;
  for (const LightGroup& group : grid.groups) colours.emplace_back().fill(group.begins_dark ? 0.0f : 1.0f);
  return colours;
}

FileResult mixLight(const std::vector<std::array<float, 3>>& colours, LightGrid* grid) {
  // light is linear: groups add up in their colours, and the sum must keep to the limits of any light
  std::vector<float> mixed(grid->probe_function.size() * kShFloats, 0.0f);
  for (size_t g = 0; g < grid->groups.size(); ++g) {
    const float* light = grid->groups[g].light.data();
    std::array<float, kShFloats> factors;
    for (size_t k = 0; k < kShFloats; ++k) factors[k] = colours[g][k % kShChannels];
    for (size_t probe = 0; probe < mixed.size(); probe += kShFloats) {
      for (size_t k = 0; k < kShFloats; ++k) mixed[probe + k] += factors[k] * light[probe + k];
    }
  }
  FileResult result = checkLight(mixed);
  if (result.ok()) grid->light = std::move(mixed);
  return result;
}

FileResult takePackedLight(LightGrid* grid) {
  std::vector<std::vector<float>> light;
  FileResult result = unpackGridLight(grid->packed_light, grid->probe_function, std::max<size_t>(1, grid->groups.size()), &light);
  if (!result.ok()) return result;
  if (grid->groups.empty()) {
    result = checkLight(light[0]);
    if (result.ok()) grid->light = std::move(light[0]);
    return result;
  }
  for (size_t g = 0; g < grid->groups.size(); ++g) grid->groups[g].light = std::move(light[g]);
  return mixLight(startingColours(*grid), grid);
}

LightPacking roundGridLight(double max_error, LightGrid* grid) {
  LightPacking packing;
  grid->packed_light = packedAnew(*grid, max_error, &packing);
  takePackedLight(grid);
  return packing;
}

bool holdsPackedLight(const LightGrid& grid) {
  const std::vector<const std::vector<float>*> light = lightByGroup(grid);
  std::vector<std::vector<float>> packed;
  return unpackGridLight(grid.packed_light, grid.probe_function, light.size(), &packed).ok() &&
         std::equal(packed.begin(), packed.end(), light.begin(), [](const auto& a, const auto* b) { return a == *b; });
}

PackedLight packedLightOf(const LightGrid& grid, double max_error) {
  LightPacking packing;
  return holdsPackedLight(grid) ? grid.packed_light : packedAnew(grid, max_error, &packing);
}

FileResult checkLight(const std::vector<float>& light) { return checkValues("light", light, kMaxGridLight); }

}  // namespace nlg
