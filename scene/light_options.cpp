#include "scene/light_options.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "scene/sky_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kRadiansPerDegree = 0.017453292519943295;
constexpr double kBrightest = 1e12;
constexpr const char* kSkyForm =
    "r,g,b, or those of zenith, horizon and ground, each from 0 to 1e12; FILE.hdr or FILE.exr, which turn in degrees and factor "
    "may follow; or 0 for none";
constexpr const char* kSunForm = "azimuth and elevation in degrees, and r,g,b from 0 to 1e12; or 0 for none";

std::vector<double> numbersOf(const std::vector<std::string>& texts, const UsageError& error) {
  std::vector<double> numbers;
  for (const std::string& text : texts) {
    char* end = nullptr;
    numbers.push_back(std::strtod(text.c_str(), &end));
    if (text.empty() || *end != '\0' || !std::isfinite(numbers.back())) throw error;
  }
  return numbers;
}

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ",") + text;
  return all;
}

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

bool isBright(const glm::vec3& colour) { return colour.r > 0.0f || colour.g > 0.0f || colour.b > 0.0f; }

}  // namespace

void describe(LightOptions& options, OptionTable& table) {
  table.add(
      "sky", &options.sky,
      "radiance of the sky: r,g,b; or nine numbers, of zenith, horizon and ground; or FILE.hdr or FILE.exr, all around (its "
      "middle looks along +x; FILE,DEGREES turns it towards +z, FILE,DEGREES,FACTOR makes it brighter); or 0, no sky. In the "
      "unit of the scene's lamps and emission. None: the scene's own");
  table.add("sun", &options.sun,
            "a sun: its azimuth and elevation, degrees, and its irradiance r,g,b; or 0, no sun. None: the scene's own");
}

bool hasLight(const Scene& scene) {
  const SceneLight& light = scene.light;
  if (!light.baked.empty()) return true;
  if (isBright(light.sky.zenith) || isBright(light.sky.horizon) || isBright(light.sky.ground)) return true;
  for (const Sun& sun : light.suns) {
    if (isBright(sun.irradiance)) return true;
  }
  for (const Lamp& lamp : light.lamps) {
    if (isBright(lamp.intensity)) return true;
  }
  if (std::any_of(light.sky_faces.shine.begin(), light.sky_faces.shine.end(), isBright)) return true;
  return std::any_of(scene.triangle_material.begin(), scene.triangle_material.end(),
                     [&](uint32_t material) { return isBright(scene.materials[material].emissive); });
}

Sky defaultSky() { return {{0.35f, 0.55f, 0.95f}, {0.80f, 0.90f, 1.00f}, {0.20f, 0.18f, 0.15f}}; }
Sun defaultSun() { return sunAt(120.0, 50.0, {5.0f, 4.7f, 4.1f}); }

std::vector<std::string> applyLight(Scene& scene, const LightOptions& options) {
  std::vector<std::string> done;
  if (!options.sky.empty()) {
    GivenSky given = skyFrom(options.sky);
    scene.light.sky = std::move(given.sky);
    done.push_back("sky: " + joined(options.sky));
    done.insert(done.end(), given.notes.begin(), given.notes.end());
    if (given.sun) {
      done.push_back("the sun of the image is a sun of its own: " + sunText(*given.sun) +
                     (options.sun.empty() ? "" : "; --sun stands in its place"));
      scene.light.suns.push_back(*given.sun);
    }
  }
  if (!options.sun.empty()) {
    scene.light.suns = sunsFrom(options.sun);
    done.push_back("sun: " + joined(options.sun));
  }
  if (!done.empty() || hasLight(scene)) return done;
  scene.light.sky = defaultSky();
  scene.light.suns = {defaultSun()};
  done.push_back("nothing shines in the scene: a clear sky and a sun by default (--sky, --sun)");
  return done;
}

}  // namespace nlg
