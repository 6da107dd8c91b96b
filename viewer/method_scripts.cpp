#include "viewer/method_scripts.h"

#include <array>
#include <cmath>

#include "nlg/shader_grid.h"
#include "runtime_eval/numbers/half.h"
#include "tool/error.h"

namespace nlg {
namespace {

ShaderGrid packed(const LightGrid& grid) {
  ShaderGrid result;
  const FileResult status = packShaderGrid(grid, &result);
  if (!status.ok())
    throw InputError("the light grid", fileStatusName(status.status), "a grid that shaders can show", status.detail);
  return result;
}

void addWords(const ShaderGrid& grid, DataScript* script) {
  script->add("words", grid.words);
  script->facts["header_count"] = grid.header_count;
  script->facts["defines"] = grid.defines;
}

uint32_t halfBits(float value) {
  Half half;
  return halfFromFloat(value, &half) ? half.bits : 0x7bffu;  // asShipped has rounded it already
}

void append(std::vector<float>* numbers, const glm::vec3& v) { numbers->insert(numbers->end(), {v.x, v.y, v.z}); }

}  // namespace

DataScript gridScript(const std::string& name, const LightGrid& grid) {
  DataScript script(name);
  script.facts["kind"] = "grid";
  const ShaderGrid words = packed(grid);
  addWords(words, &script);
  script.facts["groups"] = words.groups;
  script.facts["first_colour"] = words.first_colour;
  return script;
}

LightGrid trilinearGrid(const ProbeSet& probes, const std::vector<LightSh>& light, bool of_all_probes) {
  LightGrid grid;
  grid.tree = probes.tree;
  for (size_t p = 0; p < probes.count(); ++p) {
    grid.probe_function.push_back(of_all_probes || probes.is_in_air[p] ? kFreeSpace : kNoWeight);
    for (const glm::vec3& coefficient : light[p]) append(&grid.light, coefficient);
  }
  return grid;
}

DataScript ddgiScript(const ProbeSet& probes, const DdgiMaps& maps) {
  DataScript script("ddgi");
  script.facts["kind"] = "ddgi";
  addWords(packed(trilinearGrid(probes, std::vector<LightSh>(probes.count()), true)), &script);
  script.facts["scale"] = maps.scale;
  std::vector<uint32_t> words(kDdgiMapWords * maps.probes.size());
  for (size_t p = 0; p < maps.probes.size(); ++p) {
    const DdgiProbe& probe = maps.probes[p];
    uint32_t* word = &words[kDdgiMapWords * p];
    *word++ = probe.is_active ? 1 : 0;
    for (const glm::vec3& texel : probe.irradiance.texels) {
      const auto ten = [](float value) { return static_cast<uint32_t>(std::lround(1023.0f * value)); };
      *word++ = ten(texel.r) | ten(texel.g) << 10 | ten(texel.b) << 20;
    }
    for (const glm::vec2& texel : probe.depth.texels) *word++ = halfBits(texel.x) | halfBits(texel.y) << 16;
  }
  script.add("maps", words);
  return script;
}

DataScript probesScript(const LightGrid& grid, const std::vector<uint8_t>& is_in_air) {
  NLG_CHECK(is_in_air.size(), ==, grid.probe_function.size());
  DataScript script("probes");
  const ShaderGrid shader_grid = packed(grid);
  std::vector<float> positions, cells;
  std::vector<uint8_t> kinds;
  std::array<uint64_t, 4> counts{};
  for (size_t p = 0; p < grid.probe_function.size(); ++p) {
    const PositionM at = grid.tree.probePosition(p);
    append(&positions, glm::vec3(at[0], at[1], at[2]));
    const uint32_t function = grid.probe_function[p];
    const ProbeKind kind = function == kNoWeight    ? ProbeKind::empty
                           : function == kFreeSpace ? ProbeKind::bare_tent
                           : is_in_air[p]           ? ProbeKind::function
                                                    : ProbeKind::function_in_solid;
    kinds.push_back(static_cast<uint8_t>(kind));
    ++counts[static_cast<size_t>(kind)];
  }
  const ProbeTreeFrame& frame = grid.tree.frame();
  grid.tree.forEachCell([&](const ProbeCell& cell) {
    for (size_t axis = 0; axis < 3; ++axis)
      cells.push_back(static_cast<float>(frame.first_m[axis] + frame.spacing_m * cell.low[axis]));
    cells.push_back(static_cast<float>(frame.spacing_m * cell.side));
  });
  script.facts["counts"] = counts;
  script.add("positions", positions);
  script.add("kinds", kinds);
  script.add("records", shader_grid.probe_record);
  script.add("cells", cells);
  return script;
}

}  // namespace nlg
