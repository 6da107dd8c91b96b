#include "datagen/commands.h"

#include <set>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "scene/archive/pk3_archive.h"
#include "scene/lights/light_options.h"
#include "scene/model/scene.h"
#include "tool/printable.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }
Json rounded(const glm::dvec3& v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }

double areaOf(const Scene& scene, const glm::uvec3& t) {
  const glm::dvec3 a(scene.positions[t.x]);
  return 0.5 * glm::length(glm::cross(glm::dvec3(scene.positions[t.y]) - a, glm::dvec3(scene.positions[t.z]) - a));
}

// By what a surface is to weighting functions, its share of all area.
Json surfaceShares(const Scene& scene) {
  constexpr std::array<const char*, 4> kNames = {"solid", "sheets", "dense_transmissive", "thin_transmissive"};
  std::array<double, 4> area{};
  double total = 0.0;
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    const Material& material = scene.materials[scene.triangle_material[i]];
    const size_t kind = material.transmissive == Transmissive::thin    ? 3
                        : material.transmissive == Transmissive::dense ? 2
                        : material.double_sided                        ? 1
                                                                       : 0;
    const double triangle_area = areaOf(scene, scene.triangles[i]);
    area[kind] += triangle_area;
    total += triangle_area;
  }
  Json shares = Json::object();
  for (size_t kind = 0; kind < kNames.size(); ++kind) shares[kNames[kind]] = total > 0.0 ? rounded(area[kind] / total) : 0.0;
  return shares;
}

// The faintest and the brightest, by their brightest channel.
template <class Light, class Brightness>
Json extremes(const std::vector<Light>& lights, const Brightness& of) {
  if (lights.empty()) return Json::array();
  float least = INFINITY, most = 0.0f;
  for (const Light& light : lights) {
    const glm::vec3 brightness = of(light);
    const float brightest = std::max({brightness.x, brightness.y, brightness.z});
    least = std::min(least, brightest);
    most = std::max(most, brightest);
  }
  return {rounded(least), rounded(most)};
}

}  // namespace

bool isShardRequest(const std::string& request) {
  if (extensionOf(request) == ".h5") return true;
  std::error_code error;
  return formatOf(request) == nullptr && !isOtherFormat(request) && std::filesystem::is_regular_file(request, error);
}

Json describeScene(const std::string& request, const SceneReading& reading) {
  const SceneSource source = loadScene(request, reading);
  const Scene& scene = source.scene;
  const Bounds bounds = sceneBounds(scene);
  uint64_t texels = 0;
  for (const TextureImage& image : scene.images) texels += image.texels.size();
  // those of triangles: of a material that bounds solid here and not there a copy stands beside it
  std::vector<Material> used;
  for (const uint32_t m : std::set<uint32_t>(scene.triangle_material.begin(), scene.triangle_material.end()))
    used.push_back(scene.materials[m]);
  const auto count = [&](const auto& holds) { return std::count_if(used.begin(), used.end(), holds); };
  // emission of materials that triangles have: a library's others light nothing
  std::vector<glm::vec3> shining;
  for (const Material& material : used) {
    if (material.emissive != glm::vec3(0.0f)) shining.push_back(material.emissive);
  }
  // what a user compares with the modelling program, in metres and in the file's units of light
  Json json = {{"scene", request},
               {"triangles", scene.triangles.size()},
               {"triangles_without_area", scene.dropped_triangle_count},
               {"objects", scene.objects.size()},
               {"size_m", rounded(glm::dvec3(bounds.max) - glm::dvec3(bounds.min))},
               {"middle_m", rounded(scene.origin_m + 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max)))},
               {"unit_m", source.unit_m > 0.0 ? source.unit_m : 1.0},
               {"surfaces", surfaceShares(scene)},
               {"materials", used.size()},
               {"materials_with_image", count([](const Material& m) { return m.base_image.isThere(); })},
               {"images", scene.images.size()},
               {"image_bytes", 4 * texels},
               {"vertex_colours", !scene.vertex_colours.empty()},
               {"lamps", scene.light.lamps.size()},
               {"lamps_cd", extremes(scene.light.lamps, [](const Lamp& lamp) { return lamp.intensity; })},
               {"suns_lux", extremes(scene.light.suns, [](const Sun& sun) { return sun.irradiance; })},
               {"materials_that_shine", shining.size()},
               {"shine_cd_per_m2", extremes(shining, [](const glm::vec3& radiance) { return radiance; })},
               {"sky", scene.light.sky.zenith != glm::vec3(0.0f) || scene.light.sky.horizon != glm::vec3(0.0f)},
               {"baked_light", !scene.light.baked.empty()},
               {"viewpoints", scene.viewpoints.size()},
               {"sha256", sceneSha256(scene)}};
  // what was changed, skipped or guessed on reading
  Json notes = Json::array();
  for (const std::string& note : source.notes) notes.push_back(note);
  for (const std::string& note : source.light_notes) notes.push_back(note);
  if (isInOtherUnit(scene))
    notes.push_back(
        fmt::format("lamps and suns are {} in the file; beside emission or a sky a bake turns them into its unit (--light-unit)",
                    scene.light.unit.kind == LightUnit::Kind::over_pi ? "divided by pi"
                    : scene.light.unit.kind == LightUnit::Kind::raw   ? "in raw W of Blender"
                                                                      : "683 times their W of Blender"));
  if (const std::string unsure = unsureUnit(scene); !unsure.empty()) notes.push_back(unsure);
  for (const std::string& line : source.counts) notes.push_back(line);
  json["notes"] = notes;
  return json;
}

std::string sceneDigest(const std::string& request, SceneReading reading) {
  reading.images = ImageNeed::geometry;
  return sceneSha256(loadScene(request, reading).scene);
}

std::string sceneText(const Json& scene) {
  std::string text = printable(scene["scene"].get<std::string>()) + "\n";
  std::string title;
  // a title stands once, before its first line
  const auto line = [&](const char* name, const std::string& words) {
    text += fmt::format("  {:<12}{}\n", title == name ? "" : name, words);
    title = name;
  };
  // plural and unit are the text's, JSON keeps plain numbers
  const auto counted = [&](const char* key, const char* what) {
    const auto count = scene[key].get<uint64_t>();
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
  };
  const auto number = [&](const char* key) { return scene[key].get<double>(); };
  const auto three = [&](const char* key, const char* between) {
    const Json& v = scene[key];
    return fmt::format("{:g}{}{:g}{}{:g}", v[0].get<double>(), between, v[1].get<double>(), between, v[2].get<double>());
  };
  const auto range = [&](const char* key, const char* unit) {
    const double least = scene[key].empty() ? 0.0 : scene[key][0].get<double>();
    const double most = scene[key].empty() ? 0.0 : scene[key][1].get<double>();
    return least == most ? fmt::format("{:g} {}", most, unit) : fmt::format("{:g} to {:g} {}", least, most, unit);
  };
  line("triangles", fmt::format("{} in {}", scene["triangles"].get<uint64_t>(), counted("objects", "object")));
  if (number("triangles_without_area") > 0.0)
    line("triangles", fmt::format("{} more without area, left out", scene["triangles_without_area"].get<uint64_t>()));
  line("size",
       fmt::format("{} m at {:g} m a unit, its middle at {}", three("size_m", " x "), number("unit_m"), three("middle_m", " ")));
  // shares of area by kind: they show at a glance what bounds solid
  std::string surfaces;
  for (const auto& [kind, share] : scene["surfaces"].items()) {
    if (share.get<double>() == 0.0) continue;
    std::string words = kind;
    std::replace(words.begin(), words.end(), '_', ' ');
    surfaces += fmt::format("{}{:.3g} % {}", surfaces.empty() ? "" : ", ", 100.0 * share.get<double>(), words);
  }
  line("surfaces", surfaces.empty() ? "none" : surfaces);
  line("materials", fmt::format("{}, {} of them with an image{}", number("materials"), number("materials_with_image"),
                                scene["vertex_colours"].get<bool>() ? "; vertices have colours" : ""));
  line("images", fmt::format("{}, kept in {:.1f} MB", number("images"), number("image_bytes") / 1e6));
  // by source, each in its own unit: a factor of 683 too much shows here
  if (number("materials_that_shine") > 0.0)
    line("light", fmt::format("{} of the materials {}, {}", number("materials_that_shine"),
                              number("materials_that_shine") == 1.0 ? "shines" : "shine", range("shine_cd_per_m2", "cd/m²")));
  if (number("lamps") > 0.0) line("light", fmt::format("{}, {}", counted("lamps", "lamp"), range("lamps_cd", "cd")));
  if (!scene["suns_lux"].empty()) line("light", "sun, " + range("suns_lux", "lux"));
  if (scene["sky"].get<bool>()) line("light", "sky");
  if (scene["baked_light"].get<bool>()) line("light", "what the level's compiler left on its surfaces");
  if (title != "light") line("light", "none");
  line("viewpoints", fmt::format("{}", number("viewpoints")));
  for (const Json& note : scene["notes"]) line("notes", printable(note.get<std::string>()));
  return text;
}

}  // namespace nlg
