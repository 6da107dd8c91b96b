#include "viewer/data_script.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "nlg/shader_grid.h"
#include "runtime_eval/numbers/half.h"
#include "tool/base64.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kMostImageBytes = 8u << 20;  // of a page, before base64
constexpr int kLargestSide = 256, kSmallestSide = 4;

int sideOf(size_t image_count) {
  int side = kLargestSide;
  while (side > kSmallestSide && 4u * side * side * image_count > kMostImageBytes) side /= 2;
  return side;
}

// Means over evenly spread samples, as many as the image has texels there.
void appendLayer(const TextureImage& image, int side, std::vector<uint8_t>* bytes) {
  const int across = std::max(1, (image.width + side - 1) / side), down = std::max(1, (image.height + side - 1) / side);
  const TextureUse clamped{0, TextureWrap::clamp, TextureWrap::clamp};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      glm::vec4 sum(0.0f);
      for (int j = 0; j < down; ++j) {
        for (int i = 0; i < across; ++i)
          sum += texelAt(image, clamped, glm::vec2(x + (i + 0.5f) / across, y + (j + 0.5f) / down) / static_cast<float>(side));
      }
      sum /= static_cast<float>(across * down);
      for (int c = 0; c < 3; ++c) bytes->push_back(srgbFromLinear(sum[c]));
      bytes->push_back(static_cast<uint8_t>(std::lround(255.0f * sum.a)));
    }
  }
}

float wrapCode(const TextureUse& use) { return 3.0f * static_cast<float>(use.wrap_u) + static_cast<float>(use.wrap_v); }

template <class Vector>
std::vector<float> numbersOf(const std::vector<Vector>& vectors) {
  std::vector<float> numbers;
  for (const Vector& vector : vectors) {
    for (int i = 0; i < vector.length(); ++i) numbers.push_back(vector[i]);
  }
  return numbers;
}

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

static_assert(std::endian::native == std::endian::little, "arrays of a page are little-endian");

std::string DataScript::text() const {
  nlohmann::ordered_json all = facts;
  all["arrays"] = arrays_;
  // no name of a scene may break its encoding
  const std::string json = all.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return "nlgReceive(\"" + name_ + "\", " + json + ", \"" + base64(bytes_) + "\");\n";
}

void addLooks(const Scene& scene, DataScript* script) {
  const bool has_transmissive = std::any_of(scene.materials.begin(), scene.materials.end(),
                                            [](const Material& m) { return m.transmissive != Transmissive::none; });
  if (scene.images.empty() && scene.vertex_colours.empty() && !has_transmissive) return;
  std::vector<float> looks;
  for (const Material& material : scene.materials) {
    // the page draws a transmissive surface's colour where it is not transparent: what it transmits in that colour is let through
    // as it is
    const float transparent = 1.0f - material.opacity * (1.0f - material.transmission);
    looks.insert(looks.end(), {static_cast<float>(material.base_image.image + 1), wrapCode(material.base_image),
                               static_cast<float>(material.emissive_image.image + 1), wrapCode(material.emissive_image),
                               material.transmissive == Transmissive::none ? -1.0f : transparent});
  }
  const int side = sideOf(scene.images.size());
  std::vector<uint8_t> texels;
  for (const TextureImage& image : scene.images) appendLayer(image, side, &texels);
  script->add("material_looks", looks);
  script->add("base_places", numbersOf(scene.base_places));
  script->add("emissive_places", numbersOf(scene.emissive_places));
  script->add("vertex_colours", numbersOf(scene.vertex_colours));
  script->add("images", texels);
  script->facts["images_of"] = {{"side", side}, {"count", scene.images.size()}};
}

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
  // kinds of probes, as the page tells them apart; a probe in solid has the function of its eye
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
  // cells as low corner and side, in world coordinates
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
