// Scenes of extreme size and place, and triangles that no modeller meant.

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "datagen/scene/gltf_reader.h"
#include "datagen/scene/procedural.h"
#include "runtime_eval/support/random.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "validate/stability/face_scene.h"
#include "validate/stability/stability_case.h"

namespace nlg {
namespace {

// The finest spacing is this one, not drawn.
ProbePlacementOptions exactSpacing(double spacing_m) {
  ProbePlacementOptions options;
  options.spacing_min_m = options.spacing_max_m = spacing_m;
  return options;
}

constexpr double kSpacing = 0.7;  // of a furnished room

uint64_t probeLimit(const StabilityInputs& inputs) { return inputs.depth == StabilityDepth::brief ? 24 : 200; }

std::string describe(const ProbeFunctions& probes) {
  return fmt::format("{} probes of {}: {} functions, {} in free space, {} in solid, {} empty, {} unsound", probes.outcomes.size(),
                     probes.probe_count, probes.count(ProbeOutcome::function), probes.count(ProbeOutcome::free_space),
                     probes.count(ProbeOutcome::in_solid), probes.count(ProbeOutcome::empty), probes.broken);
}

void addFigures(const ProbeFunctions& probes, StabilityResult* result) {
  result->figures["probes"] = static_cast<double>(probes.outcomes.size());
  result->figures["functions"] = static_cast<double>(probes.count(ProbeOutcome::function));
  result->figures["unsound"] = static_cast<double>(probes.broken);
}

void addFigures(const FunctionDifference& apart, StabilityResult* result) {
  result->figures["largest_byte_difference"] = apart.largest_bytes;
  result->figures["points_compared"] = static_cast<double>(apart.points);
  result->figures["points_apart"] = static_cast<double>(apart.points_apart);
  result->figures["validity_apart"] = static_cast<double>(apart.validity_apart);
}

std::string describe(const FunctionDifference& apart) {
  if (!apart.same_outcomes) return "other outcomes";
  return fmt::format("largest byte difference of phi {}, {} of {} points more than one byte apart, {} in validity",
                     apart.largest_bytes, apart.points_apart, apart.points, apart.validity_apart);
}

// --- size and place ---------------------------------------------------------------------------------------------------------

FaceScene scaled(FaceScene faces, double scale, const glm::dvec3& shift) {
  for (glm::dvec3& position : faces.positions()) position = scale * position + shift;
  return faces;
}

// Rounding a position to float moves it by 6e-8 of its size; only points whose link or ray passes an edge so closely may change.
constexpr double kGrazingShare = 1e-4;

StabilityResult measureScale(const StabilityInputs& inputs, double scale) {
  const ProbeFunctions room = probeFunctions(furnishedRoom().finish(), exactSpacing(kSpacing), probeLimit(inputs));
  const ProbeFunctions other = probeFunctions(scaled(furnishedRoom(), scale, glm::dvec3(0.0)).finish(),
                                              exactSpacing(kSpacing * scale), probeLimit(inputs));
  const FunctionDifference apart = difference(room, other);
  StabilityResult result;
  result.passes =
      apart.same_outcomes && other.broken == 0 && room.count(ProbeOutcome::function) > 0 &&
      static_cast<double>(apart.points_apart + apart.validity_apart) <= kGrazingShare * static_cast<double>(apart.points);
  result.measured = describe(other) + "; against the room of 4 m: " + describe(apart);
  addFigures(other, &result);
  addFigures(apart, &result);
  return result;
}

// Spacings that do not suit the scene: refused with a line that helps, or few probes.
StabilityResult measureSpacings(const StabilityInputs&) {
  std::string refusal;
  try {
    probeFunctions(
        scaled(furnishedRoom(), 25000.0, glm::dvec3(0.0)).finish(),
        [] {
          ProbePlacementOptions options;
          options.density_growth = 0.0;
          return options;
        }(),
        1);
  } catch (const UsageError& error) {
    refusal = error.what();
  }
  const ProbeFunctions tiny = probeFunctions(scaled(furnishedRoom(), 0.00025, glm::dvec3(0.0)).finish(), {}, 64);
  StabilityResult result;
  result.passes =
      refusal.find("spacing") != std::string::npos && tiny.probe_count > 0 && tiny.probe_count <= 64 && tiny.broken == 0;
  result.measured =
      fmt::format("100 km: {}; 1 mm: {}", refusal.empty() ? "not refused" : "refused (" + refusal + ")", describe(tiny));
  addFigures(tiny, &result);
  return result;
}

StabilityResult measureFarAway(const StabilityInputs& inputs) {
  FaceScene house;
  house.add(makeProceduralScene("house", 3));
  const ProbeFunctions here = probeFunctions(house.finish(), exactSpacing(kSpacing), probeLimit(inputs));
  StabilityResult result;
  result.passes = here.count(ProbeOutcome::function) > 0 && here.broken == 0;
  FunctionDifference worst;
  for (const glm::dvec3& shift : {glm::dvec3(100000.0, 0.0, 0.0), glm::dvec3(-100000.0, 3000.0, 70001.0)}) {
    const ProbeFunctions there = probeFunctions(scaled(house, 1.0, shift).finish(), exactSpacing(kSpacing), probeLimit(inputs));
    const FunctionDifference apart = difference(here, there);
    result.passes = result.passes && apart.same_bits();
    if (worst.points == 0 || apart.largest_bytes > worst.largest_bytes || !apart.same_outcomes) worst = apart;
  }
  result.measured = describe(here) + "; 100 km away: " + describe(worst);
  addFigures(here, &result);
  addFigures(worst, &result);
  return result;
}

// --- triangles that no modeller meant ---------------------------------------------------------------------------------------

// Soundness alone: whatever the triangles are, every probe has an outcome and every function keeps its promises, twice alike.
StabilityResult measureSound(const StabilityInputs& inputs, const FaceScene& faces) {
  const Scene scene = faces.finish();
  const ProbeFunctions once = probeFunctions(scene, exactSpacing(kSpacing), probeLimit(inputs));
  const ProbeFunctions again = probeFunctions(scene, exactSpacing(kSpacing), probeLimit(inputs));
  StabilityResult result;
  result.passes = once.broken == 0 && !once.outcomes.empty() && difference(once, again).same_bits();
  result.measured = fmt::format("{}; {} votes about solid disputed", describe(once), once.disputed);
  addFigures(once, &result);
  result.figures["disputed"] = static_cast<double>(once.disputed);
  return result;
}

constexpr const char* kSoundMustHold =
    "every probe has an outcome, every phi is in [0, 1] and 0 in solid, and a second run gives the same bits";

// … and what was added changes nothing at all.
StabilityResult measureUnchanged(const StabilityInputs& inputs, const FaceScene& faces, uint32_t expected_drops) {
  const Scene scene = faces.finish();
  const ProbeFunctions room = probeFunctions(furnishedRoom().finish(), exactSpacing(kSpacing), probeLimit(inputs));
  const ProbeFunctions other = probeFunctions(scene, exactSpacing(kSpacing), probeLimit(inputs));
  const FunctionDifference apart = difference(room, other);
  StabilityResult result;
  result.passes = apart.same_bits() && other.broken == 0 && scene.dropped_triangle_count == expected_drops;
  result.measured = fmt::format("{} triangles dropped and counted; against the room without them: {}",
                                scene.dropped_triangle_count, describe(apart));
  addFigures(other, &result);
  addFigures(apart, &result);
  result.figures["dropped_triangles"] = scene.dropped_triangle_count;
  return result;
}

FaceScene withZeroArea(uint32_t* count) {
  FaceScene faces = furnishedRoom();
  Random random(41);
  for (*count = 0; *count < 60; ++*count) {
    const glm::dvec3 a(random.uniform(0, 4), random.uniform(0, 3), random.uniform(0, 4)), b(random.uniform(0, 4), 1.0, 1.0);
    // a point, a line there and back
    faces.addTriangle(a, *count % 2 == 0 ? a : b, a);
  }
  return faces;
}

FaceScene withDuplicates() {
  FaceScene faces = furnishedRoom();
  faces.add(furnishedRoom().finish());
  return faces;
}

FaceScene withSlivers() {
  FaceScene faces = furnishedRoom();
  Random random(43);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 a(random.uniform(0, 3), random.uniform(0, 2), random.uniform(0, 3));
    // 1 m long, a micrometre wide
    faces.addTriangle(a, a + glm::dvec3(1.0, 0.3, 0.2), a + glm::dvec3(0.0, 1e-6, 0.0),
                      i % 2 ? FaceScene::Sides::one : FaceScene::Sides::two);
  }
  return faces;
}

// Every face of share `share` turned round.
FaceScene flipped(double share) {
  FaceScene faces = furnishedRoom();
  Random random(47);
  for (size_t t = 0; t < faces.triangleCount(); ++t) {
    if (random.chance(share)) std::swap(faces.positions()[3 * t + 1], faces.positions()[3 * t + 2]);
  }
  return faces;
}

// Every fifth triangle is missing.
FaceScene open() {
  const FaceScene whole = furnishedRoom();
  FaceScene faces;
  FaceScene copy = whole;
  for (size_t t = 0; t < copy.triangleCount(); ++t) {
    if (t % 5 != 2) faces.addTriangle(copy.positions()[3 * t], copy.positions()[3 * t + 1], copy.positions()[3 * t + 2]);
  }
  return faces;
}

// Probes on a lattice of 1 m whose planes are the planes of sheets, and vertices that are probes.
StabilityResult measureOnProbes(const StabilityInputs&) {
  FaceScene faces;
  using Sides = FaceScene::Sides;
  faces.addBox({-3, -3, -3}, {3, 3, 3}, true);
  faces.addQuad({-2, 0, -2}, {-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, Sides::two);  // through nine probes
  faces.addQuad({1, -2, -2}, {1, -2, 2}, {1, 2, 2}, {1, 2, -2}, Sides::one);
  faces.addTriangle({-1, 1, -1}, {-1, 1, 1}, {-1, 2, 0}, Sides::two);  // two corners are probes
  const Scene scene = faces.finish();
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 125; ++i) positions.push_back(glm::dvec3(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2) - scene.origin_m);
  const ProbeFunctions once = functionsAt(scene, positions, 1.0f), again = functionsAt(scene, positions, 1.0f);
  uint64_t lit_through = 0;
  // row of a function in the sheet y = 0, inside its rim: lit on one side at most
  uint64_t row = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (once.outcomes[i] != ProbeOutcome::function) continue;
    const glm::dvec3 at = positions[i] + scene.origin_m;
    uint64_t above = 0, below = 0;
    for (int p = 0; p < kSupportPointCount; ++p) {
      const bool lit = once.functions.phi[row * kSupportPointCount + p] > 0;
      above += lit && supportPattern().points[p][1] > 0.001f;
      below += lit && supportPattern().points[p][1] < -0.001f;
    }
    if (at.y == 0.0 && std::fabs(at.x) < 1.0 && std::fabs(at.z) < 1.0) lit_through += std::min(above, below);
    ++row;
  }
  StabilityResult result;
  result.passes = once.broken == 0 && difference(once, again).same_bits() && lit_through == 0;
  result.measured = fmt::format("{}; {} points lit on a second side of a sheet through the probe", describe(once), lit_through);
  addFigures(once, &result);
  result.figures["lit_through"] = static_cast<double>(lit_through);
  return result;
}

// A file of one triangle, its second corner's x being the value.
std::string gltfTriangle(float value) {
  const float corners[9] = {0, 0, 0, value, 0, 0, 0, 1, 0};
  std::string bytes(sizeof corners, '\0');
  std::memcpy(bytes.data(), corners, sizeof corners);
  std::string json =
      R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto word = [](size_t number) {
    const auto value32 = static_cast<uint32_t>(number);
    std::string text(sizeof value32, '\0');
    std::memcpy(text.data(), &value32, sizeof value32);
    return text;
  };
  return "glTF" + word(2) + word(28 + json.size() + bytes.size()) + word(json.size()) + "JSON" + json + word(bytes.size()) +
         std::string("BIN\0", 4) + bytes;
}

StabilityResult measureNotFinite(const StabilityInputs&) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("nlg_stability_" + std::to_string(::getpid()));
  const std::string path = (folder / "triangle.glb").string();
  const auto lineOf = [&](float value) -> std::string {
    writeFileAtomically(path, gltfTriangle(value));
    try {
      readGltf(path);
    } catch (const InputError& error) {
      return std::string(error.what()).substr(path.size() + 2);
    }
    return "";
  };
  const float infinity = std::numeric_limits<float>::infinity();
  const std::string nan = lineOf(std::nanf("")), inf = lineOf(infinity), minus = lineOf(-infinity), good = lineOf(1.0f);
  std::filesystem::remove_all(folder);
  StabilityResult result;
  result.passes = !nan.empty() && !inf.empty() && !minus.empty() && good.empty();
  result.measured = fmt::format("NaN: {}; Inf: {}; a finite one is {}", nan.empty() ? "read" : "refused (" + nan + ")",
                                inf.empty() || minus.empty() ? "read" : "refused", good.empty() ? "read" : "refused");
  result.figures = {{"refused", double(!nan.empty() + !inf.empty() + !minus.empty())}};
  return result;
}

// --- how many triangles -----------------------------------------------------------------------------------------------------

StabilityResult measureNone(const StabilityInputs&) {
  const Scene scene = FaceScene().finish();
  const ProbeFunctions asked = probeFunctions(scene, {}, 10);
  ProbePlacementOptions somewhere;
  somewhere.extent = ExtentBox{glm::dvec3(0.0), glm::dvec3(3.0)};
  const ProbeFunctions given = probeFunctions(scene, somewhere, 10);
  StabilityResult result;
  result.passes =
      asked.probe_count == 0 && given.probe_count > 0 && given.count(ProbeOutcome::free_space) == given.outcomes.size();
  result.measured = fmt::format("without an extent {} probes; with one: {}", asked.probe_count, describe(given));
  result.figures = {{"probes_without_extent", double(asked.probe_count)}, {"probes_with_extent", double(given.probe_count)}};
  return result;
}

StabilityResult measureOne(const StabilityInputs& inputs) {
  FaceScene faces;
  faces.addTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, FaceScene::Sides::two);
  StabilityResult result = measureSound(inputs, faces);
  result.passes = result.passes && result.figures.at("functions") > 0;
  return result;
}

// Rolling ground of 2 x 2237² triangles, 100 m across.
Scene tenMillionTriangles() {
  constexpr uint32_t kSide = 2237;
  Scene scene;
  scene.id = "ten million triangles";
  scene.materials.resize(1);
  std::vector<glm::dvec3> positions;
  positions.reserve(size_t{kSide} * kSide);
  for (uint32_t z = 0; z < kSide; ++z) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const double u = 100.0 * x / (kSide - 1), v = 100.0 * z / (kSide - 1);
      positions.emplace_back(u, 2.0 * std::sin(0.31 * u) * std::cos(0.23 * v) + 0.05 * std::sin(9.0 * u + 7.0 * v), v);
    }
  }
  for (uint32_t z = 0; z + 1 < kSide; ++z) {
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t a = z * kSide + x, b = a + kSide;
      scene.triangles.push_back({a, b, b + 1});
      scene.triangles.push_back({a, b + 1, a + 1});
    }
  }
  scene.triangle_material.assign(scene.triangles.size(), 0);
  scene.objects.push_back({"ground", 0, static_cast<uint32_t>(scene.triangles.size()), false});
  finishScene(scene, positions);
  return scene;
}

StabilityResult measureTenMillion(const StabilityInputs&) {
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = tenMillionTriangles();
  const ProbeFunctions probes = probeFunctions(scene, exactSpacing(1.0), 60);
  const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const double peak_gb = static_cast<double>(usage.ru_maxrss) * 1024 * 1e-9;
  StabilityResult result;
  result.passes = scene.triangles.size() >= 9990000 && probes.broken == 0 && probes.count(ProbeOutcome::function) > 0;
  result.measured = fmt::format("{} triangles; {}; {:.0f} s, most memory of the process so far {:.1f} GB", scene.triangles.size(),
                                describe(probes), elapsed_s, peak_gb);
  addFigures(probes, &result);
  result.figures["triangles"] = static_cast<double>(scene.triangles.size());
  result.figures["elapsed_s"] = elapsed_s;
  result.figures["peak_memory_gb"] = peak_gb;
  return result;
}

StabilityCase soundCase(const std::string& name, StabilityDepth depth, const std::function<FaceScene()>& make) {
  return {"scenes", name,  kSoundMustHold,
          depth,    false, [make](const StabilityInputs& inputs) { return measureSound(inputs, make()); }};
}

}  // namespace

std::vector<StabilityCase> sceneCases() {
  const auto brief = StabilityDepth::brief, full = StabilityDepth::full, lengthy = StabilityDepth::lengthy;
  const std::string scale_must_hold =
      "the functions are those of a room of 4 m but for one point in ten thousand, whose links graze an edge";
  const std::string unchanged_must_hold = "the functions are bit for bit those of the room without the additions";
  return {
      {"scenes", "1 mm across", scale_must_hold, brief, false,
       [](const StabilityInputs& inputs) { return measureScale(inputs, 0.00025); }},
      {"scenes", "100 km across", scale_must_hold, full, false,
       [](const StabilityInputs& inputs) { return measureScale(inputs, 25000.0); }},
      {"scenes", "spacings that do not suit the scene",
       "100 km at the default spacing is refused with a line that names a spacing, 1 mm gives a handful of sound probes", brief,
       false, measureSpacings},
      {"scenes", "100 km from the origin", "the functions are bit for bit those at the origin", brief, false, measureFarAway},
      {"scenes", "triangles of zero area", "all of them are dropped and counted, and " + unchanged_must_hold, brief, false,
       [](const StabilityInputs& inputs) {
         uint32_t count = 0;
         const FaceScene faces = withZeroArea(&count);
         return measureUnchanged(inputs, faces, count);
       }},
      {"scenes", "duplicated triangles", unchanged_must_hold, full, false,
       [](const StabilityInputs& inputs) { return measureUnchanged(inputs, withDuplicates(), 0); }},
      soundCase("slivers of 1e6 to 1", full, withSlivers),
      soundCase("all triangles flipped", full, [] { return flipped(1.0); }),
      soundCase("half of the triangles flipped", full, [] { return flipped(0.5); }),
      soundCase("open geometry, every fifth triangle missing", full, open),
      {"scenes", "coplanar with the probe planes, and exactly on probes",
       "every phi is in [0, 1] and 0 in solid, a second run gives the same bits, and no probe in a sheet lights both sides of it",
       brief, false, measureOnProbes},
      {"scenes", "positions of NaN and Inf", "the file is refused with one line that names the place", brief, false,
       measureNotFinite},
      {"scenes", "no triangle", "no probe without an extent, and only free space with one", brief, false, measureNone},
      {"scenes", "one triangle", std::string(kSoundMustHold) + ", and some probe has a function", brief, false, measureOne},
      {"scenes", "ten million triangles", "functions are made, all of them sound", lengthy, false, measureTenMillion},
  };
}

}  // namespace nlg
