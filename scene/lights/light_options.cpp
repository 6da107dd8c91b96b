#include "scene/lights/light_options.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime_eval/light_grid/packed_light.h"
#include "scene/image/sky_file.h"
#include "scene/lights/light_groups.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr const char* kSkyForm =
    "r,g,b, or those of zenith, horizon and ground, each from 0 to 1e12; FILE.hdr or FILE.exr, which turn in degrees and factor "
    "may follow; or 0 for none";
constexpr const char* kSunForm =
    "azimuth,elevation,r,g,b in one word: degrees, the azimuth from +x towards +z, and irradiance from 0 to 1e12 "
    "(40,50,3,2.8,2.5); "
    "or 0 for none";

std::vector<double> numbersOf(const std::vector<std::string>& texts, const UsageError& error) {
  std::vector<double> numbers;
  for (const std::string& text : texts) {
    char* end = nullptr;
    numbers.push_back(std::strtod(text.c_str(), &end));
    if (text.empty() || *end != '\0' || !std::isfinite(numbers.back())) throw error;
  }
  return numbers;
}

std::string joined(const std::vector<std::string>& texts) { return fmt::format("{}", fmt::join(texts, ",")); }

glm::vec3 colourFrom(const std::vector<double>& numbers, size_t first, const UsageError& error) {
  glm::vec3 colour;
  for (int channel = 0; channel < 3; ++channel) {
    const double value = numbers[first + static_cast<size_t>(channel)];
    if (!(value >= 0.0 && value <= kBrightest)) throw error;
    colour[channel] = static_cast<float>(value);
  }
  return colour;
}

bool isNone(const std::vector<double>& numbers) { return numbers.size() == 1 && numbers[0] == 0.0; }

Sky skyOfColours(const std::vector<std::string>& texts, const UsageError& error) {
  const std::vector<double> numbers = numbersOf(texts, error);
  if (isNone(numbers)) return {};
  if (numbers.size() != 3 && numbers.size() != 9) throw error;
  const size_t step = numbers.size() == 9 ? 3 : 0;
  return {colourFrom(numbers, 0, error), colourFrom(numbers, step, error), colourFrom(numbers, 2 * step, error)};
}

// What --sky gives: the sun is one that a file's image has.
struct GivenSky {
  Sky sky;
  std::optional<Sun> sun;
  std::vector<std::string> notes;
};

GivenSky skyOfFile(const std::vector<std::string>& texts, const UsageError& error) {
  const std::vector<double> numbers = numbersOf({texts.begin() + 1, texts.end()}, error);
  const double turn = !numbers.empty() ? numbers[0] : 0.0, factor = numbers.size() > 1 ? numbers[1] : 1.0;
  if (numbers.size() > 2 || std::abs(turn) > 360.0 || !(factor >= 0.0 && factor <= kBrightest)) throw error;
  SkyFile file = readSkyFile(texts[0], turn / 360.0);
  for (glm::vec3& texel : file.image.texels) texel *= static_cast<float>(factor);
  GivenSky given;
  if (file.mended > 0)
    given.notes.push_back(texts[0] + ": " + std::to_string(file.mended) + " numbers that are no radiance were taken as 0");
  given.sun = takeSun(&file.image);
  given.sky = skyOfImage(std::move(file.image));
  return given;
}

GivenSky skyFrom(const std::vector<std::string>& texts) {
  const UsageError error("--sky", kSkyForm, joined(texts));
  if (isSkyFile(texts[0])) return skyOfFile(texts, error);
  return {skyOfColours(texts, error), std::nullopt, {}};
}

// Azimuth turns from +x towards +z.
Sun sunAt(double azimuth_degrees, double elevation_degrees, const glm::vec3& irradiance) {
  const double turn = azimuth_degrees * kRadiansPerDegree, rise = elevation_degrees * kRadiansPerDegree;
  Sun sun;
  sun.to_sun = glm::normalize(glm::vec3(std::cos(turn) * std::cos(rise), std::sin(rise), std::sin(turn) * std::cos(rise)));
  sun.irradiance = irradiance;
  return sun;
}

std::vector<Sun> sunsFrom(const std::vector<std::string>& texts) {
  const UsageError error("--sun", kSunForm, joined(texts));
  const std::vector<double> numbers = numbersOf(texts, error);
  if (isNone(numbers)) return {};
  if (numbers.size() != 5 || std::abs(numbers[0]) > 360.0 || std::abs(numbers[1]) > 90.0) throw error;
  return {sunAt(numbers[0], numbers[1], colourFrom(numbers, 2, error))};
}

// "azimuth 120, elevation 50 degrees, irradiance 5 4.7 4.1"
std::string sunText(const Sun& sun) {
  const double azimuth = std::atan2(sun.to_sun.z, sun.to_sun.x) / kRadiansPerDegree;
  const double elevation = std::asin(std::clamp(sun.to_sun.y, -1.0f, 1.0f)) / kRadiansPerDegree;
  return fmt::format("azimuth {:.0f}, elevation {:.0f} degrees, irradiance {:.3g} {:.3g} {:.3g}", azimuth, elevation,
                     sun.irradiance.r, sun.irradiance.g, sun.irradiance.b);
}

constexpr double kLumensPerWatt = 683.0, kFourPi = 12.566370614359172;  // that Blender's exporter multiplies and divides by

float largestOf(const glm::vec3& rgb) { return std::max({rgb.r, rgb.g, rgb.b}); }

// Emission of the triangles, the brightest.
float brightestEmission(const Scene& scene) {
  float brightest = 0.0f;
  for (const uint32_t material : scene.triangle_material)
    brightest = std::max(brightest, largestOf(scene.materials[material].emissive));
  return brightest;
}

void scaleLampsAndSuns(SceneLight* light, double of_lamps, double of_suns) {
  for (Lamp& lamp : light->lamps) lamp.intensity *= static_cast<float>(of_lamps);
  for (Sun& sun : light->suns) sun.irradiance *= static_cast<float>(of_suns);
}

void scaleAll(Scene* scene, float factor) {
  SceneLight& light = scene->light;
  scaleLampsAndSuns(&light, factor, factor);
  for (glm::vec3* radiance : {&light.sky.zenith, &light.sky.horizon, &light.sky.ground, &light.baked.ambient})
    *radiance *= factor;
  for (std::vector<glm::vec3>* radiances :
       {&light.sky.image.texels, &light.sky_faces.shine, &light.baked.texels, &light.baked.vertex_light}) {
    for (glm::vec3& radiance : *radiances) radiance *= factor;
  }
  for (Material& material : scene->materials) material.emissive *= factor;
}

// Before anything is baked: what engines' files may not hold. One light alone is asked for, so that a sum may be more.
void noteTooBright(const Scene& scene, std::vector<std::string>* notes) {
  constexpr float kOfSun = 0.631f;      // the largest coefficient of light from one direction, over its irradiance
  constexpr float kOfRadiance = 3.55f;  // and of light from everywhere, over its radiance
  float brightest = 0.0f;
  for (const Sun& sun : scene.light.suns) brightest = std::max(brightest, kOfSun * largestOf(sun.irradiance));
  // a metre away
  for (const Lamp& lamp : scene.light.lamps) brightest = std::max(brightest, kOfSun * largestOf(lamp.intensity));
  const Sky& sky = scene.light.sky;
  // half of what is seen
  brightest = std::max({brightest, 0.5f * kOfRadiance * largestOf(sky.zenith), 0.5f * kOfRadiance * largestOf(sky.horizon)});
  if (brightest <= kMaxEngineLight) return;
  notes->push_back(
      fmt::format("light may reach {:.3g}, and files for engines hold {:.0f}: {:g} times this --intensity makes it fit",
                  brightest, kMaxEngineLight, intensityThatFits(brightest)));
}

const char* kBlenderExports =
    ". If the file is of Blender: its exporter leaves lights out unless Include > Data > Punctual Lights is ticked, and never "
    "writes area lamps and the world";

// What brings lamps and suns into emission's unit.
struct UnitFactors {
  double lamps = 1.0, suns = 1.0;
};

// What is done, and how else it could be; the words are empty where nothing had to be chosen.
std::pair<UnitFactors, std::string> unitOf(const Scene& scene, const LightOptions& options, bool has_more) {
  using Kind = LightUnit::Kind;
  const UnitFactors watts{1.0 / kLumensPerWatt, 1.0 / kLumensPerWatt}, raw{1.0 / kFourPi, 1.0};
  if (options.light_unit == "file") return {};
  if (options.light_unit == "watt") return {watts, "lamps and suns divided by 683 (--light-unit)"};
  const UnitFactors pi{std::numbers::pi, std::numbers::pi};
  if (options.light_unit == "pi") return {pi, "lamps and suns times pi (--light-unit)"};
  if (options.light_unit != "auto") throw UsageError("--light-unit", "auto, file, watt or pi", "'" + options.light_unit + "'");
  const LightUnit& unit = scene.light.unit;
  if (unit.sign.empty() || (scene.light.lamps.empty() && scene.light.suns.empty())) return {};
  const std::string sign = " (" + unit.sign + ")";
  // alone they have no other light to be compared with
  if (!has_more && (unit.kind == Kind::over_pi || unit.kind == Kind::unsure)) return {};
  if (unit.kind == Kind::unsure) return {{}, unsureUnit(scene)};
  if (unit.kind == Kind::over_pi)
    return {pi, "lamps and suns times pi: " + unit.sign + "; --light-unit file takes them as they are"};
  if (unit.kind == Kind::same)
    return {{}, "lamps and suns as they are, of Blender's exporter Unitless" + sign + "; --light-unit watt divides them by 683"};
  const std::string taken = unit.kind == Kind::raw ? "Blender's raw W, lamps" : "683 times Blender's W and W/m²";
  if (!has_more)
    return {{}, "lamps and suns are " + taken + sign + ", and stay so: nothing else shines (--light-unit watt divides by 683)"};
  const std::string other = "; --light-unit file takes them as they are";
  if (unit.kind == Kind::raw) return {raw, "lamps divided by 4 pi: they are Blender's raw W" + sign + other};
  return {watts,
          "lamps and suns divided by 683: Blender's exporter multiplied them by it, and left emission as it is" + sign + other};
}

}  // namespace

void describe(LightOptions& options, OptionTable& table) {
  table.add("sky", &options.sky,
            "radiance of the sky, in the unit of the scene's light: r,g,b; nine numbers, of zenith, horizon and ground; a "
            "panorama FILE.hdr or FILE.exr, whose middle lies along +x (FILE,DEGREES turns it towards +z; FILE,DEGREES,FACTOR "
            "scales it); or 0, no sky. None: the scene's own");
  table.add("sun", &options.sun,
            "sun: azimuth,elevation,r,g,b, as 40,50,3,2.8,2.5. Angles in degrees, the azimuth from +x towards +z; r,g,b is "
            "irradiance. 0: no sun. None: the scene's own");
  table.add("light_unit", &options.light_unit,
            "unit of a glTF file's lamps and suns: file, taken as they are; watt, divided by 683; pi, multiplied by it; auto, "
            "divided if Blender's exporter multiplied them, or multiplied if Godot wrote them, and a sky, a sun or emission "
            "shines beside them",
            {"auto", "file", "watt", "pi"});
  table.add("intensity", &options.intensity, "factor on all light of the scene", 1e-12, 1e12);
  table.add("light_groups", &options.light_groups,
            "groups of light that the engine can dim, colour or switch: one, a single group; kind: sky, suns, lamps and "
            "emission; name: each sun, lamp and emissive material by its name (Lamp and Lamp.001 are one). In kind and name, "
            "light_group in a glTF file's extras overrides the group",
            {"one", "kind", "name"});
  table.add("light_state", &options.light_state,
            "name of this light, such as day, in a grid that is to hold several, which the engine mixes: --relight GRID with "
            "another name adds its light to that of GRID");
  table.addNote(
      "Light is linear, and all light of a scene has one unit. Sky and emission: radiance. Sun: irradiance on a plane that faces "
      "it. Lamp: intensity, which is the irradiance a metre away. glTF: cd/m², lux, cd. Blender, without its exporter's factor "
      "of 683: W/m²/sr, W/m², W / 4 pi. Levels of Quake III, and the default sky and sun: radiance 1 shows a white surface at "
      "full brightness.");
}

bool hasLight(const Scene& scene) {
  const SceneLight& light = scene.light;
  if (std::any_of(light.lamps.begin(), light.lamps.end(), [](const Lamp& lamp) { return isBright(lamp.intensity); })) return true;
  if (std::any_of(light.sky_faces.shine.begin(), light.sky_faces.shine.end(), isBright)) return true;
  if (light.sky.shines() || !light.baked.empty()) return true;
  if (std::any_of(light.suns.begin(), light.suns.end(), [](const Sun& sun) { return isBright(sun.irradiance); })) return true;
  return brightestEmission(scene) > 0.0f;
}

bool isInOtherUnit(const Scene& scene) {
  using Kind = LightUnit::Kind;
  return scene.light.unit.kind != Kind::same && scene.light.unit.kind != Kind::unsure;
}

std::string unsureUnit(const Scene& scene) {
  const bool is_unsure =
      scene.light.unit.kind == LightUnit::Kind::unsure && !(scene.light.lamps.empty() && scene.light.suns.empty());
  return is_unsure ? "lamps and suns as they are, as glTF's cd and lux: " + scene.light.unit.sign : "";
}

Sky defaultSky() { return {{0.35f, 0.55f, 0.95f}, {0.80f, 0.90f, 1.00f}, {0.20f, 0.18f, 0.15f}}; }
Sun defaultSun() { return sunAt(120.0, 50.0, {5.0f, 4.7f, 4.1f}); }

std::vector<std::string> applyLight(Scene& scene, const LightOptions& options, const std::function<bool(const Scene&)>& isOpen) {
  std::vector<std::string> done;
  // the default is for scenes that nothing lights, or that nothing lights from outside though they are open
  const bool is_given = !options.sky.empty() || !options.sun.empty();
  const bool is_dark = !hasLight(scene);
  const bool takes_default = !is_given && (is_dark || (isOpen && !hasLightFromOutside(scene) && isOpen(scene)));
  const bool may_lack_lamps = scene.light.writer == LightWriter::blender || (is_dark && scene.light.writer == LightWriter::gltf);
  const bool is_without_lamps = may_lack_lamps && scene.light.lamps.empty() && scene.light.suns.empty();
  // lamps and suns in emission's unit, if there is any emission (docs/theory/light.md, Units)
  const auto [factors, words] = unitOf(scene, options, is_given || takes_default || brightestEmission(scene) > 0.0f);
  scaleLampsAndSuns(&scene.light, factors.lamps, factors.suns);
  if (!words.empty()) done.push_back(words);
  // a sky replaces the scene's; the sun of its image is added to the scene's
  if (!options.sky.empty()) {
    GivenSky given = skyFrom(options.sky);
    scene.light.sky = std::move(given.sky);
    done.push_back("sky: " + joined(options.sky));
    done.insert(done.end(), given.notes.begin(), given.notes.end());
    if (given.sun) {
      done.push_back(std::string("the sun of the image is a sun of its own") +
                     (scene.light.suns.empty() ? "" : ", beside those of the scene") + ": " + sunText(*given.sun) +
                     (options.sun.empty() ? "" : "; --sun stands in its place"));
      scene.light.suns.push_back(*given.sun);
      // labels go by the suns' order: this one has no name
      scene.light.sun_labels.resize(scene.light.suns.size());
    }
  }
  if (!options.sun.empty()) {
    scene.light.suns = sunsFrom(options.sun);
    scene.light.sun_labels.clear();
    done.push_back("sun: " + joined(options.sun));
  }
  if (takes_default) {
    scene.light.sky = defaultSky();
    scene.light.suns = {defaultSun()};
    scene.light.sun_labels.clear();
    done.push_back(is_dark
                       ? "nothing shines in the scene: a clear sky and a sun by default (--sky, --sun)"
                       : "the scene is open, and no light comes from outside: a clear sky and a sun by default (--sky, --sun; "
                         "--sky 0 keeps the night)");
  }
  if (is_without_lamps) done.push_back(std::string("the file has no lamps and no suns") + kBlenderExports);
  // after everything else: the factor is on all light, defaults included
  if (options.intensity != 1.0) {
    scaleAll(&scene, static_cast<float>(options.intensity));
    done.push_back(fmt::format("all light times {:g} (--intensity)", options.intensity));
  }
  noteTooBright(scene, &done);
  groupLights(options.light_groups, options.light_state, &scene);
  return done;
}

}  // namespace nlg
