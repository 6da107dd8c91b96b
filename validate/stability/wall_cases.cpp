// Weighting functions that a builder makes beside walls, sheets and slits: where light may go, and what a bake stores of them.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datagen/weighting/weighting_builder.h"
#include "scene/model/scene.h"
#include "validate/stability/extreme_function.h"

namespace nlg {
namespace {

// Faces in world coordinates, metres.
struct Faces {
  std::vector<glm::dvec3> positions;  // three a triangle
  std::vector<uint32_t> materials;    // 1: of two sides

  // Front side: where the corners run counter-clockwise.
  void addQuad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d, bool is_double_sided) {
    positions.insert(positions.end(), {a, b, c, a, c, d});
    materials.insert(materials.end(), 2, is_double_sided);
  }

  // A closed solid whose faces look outward.
  void addBox(const glm::dvec3& low, const glm::dvec3& high) {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (const bool is_far : {false, true}) {
        glm::dvec3 a = low;
        a[axis] = is_far ? high[axis] : low[axis];
        glm::dvec3 b = a, c = a, d = a;
        b[u] = c[u] = high[u];
        c[v] = d[v] = high[v];
        addQuad(a, is_far ? b : d, c, is_far ? d : b, false);
      }
    }
  }

  // The scene as a reader of files would give it.
  Scene finish() const {
    Scene scene;
    scene.id = "stability";
    scene.materials.resize(2);
    scene.materials[1].double_sided = true;
    scene.triangle_material = materials;
    for (uint32_t t = 0; t < materials.size(); ++t) scene.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    if (!materials.empty()) scene.objects.push_back({"all", 0, static_cast<uint32_t>(materials.size()), false});
    finishScene(scene, positions);
    return scene;
  }
};

struct WallScene {
  Faces faces;
  DiffusionOptions diffusion;
  // what the probe at the origin must never light: behind something that nothing leads around
  std::function<bool(const LocalPoint&)> dark = [](const LocalPoint&) { return false; };
  // what nothing stands before: seen from the probe, so that it has the tent exactly
  std::function<bool(const LocalPoint&)> plain = [](const LocalPoint&) { return false; };
};

// What was built at the origin with a spacing of 1 m, as counts of points, over all scenes of a case.
struct Built {
  uint64_t valid = 0, seen = 0, lit = 0, lit_occluded = 0;
  // with phi that is not in [0, 1] or not 0 where invalid; lit where nothing may be; in plain sight without the tent; brighter than
  // all that is seen
  uint64_t outside_range = 0, lit_in_dark = 0, off_tent = 0, too_bright = 0;
  double brightest_occluded = 0.0;
};

void countLight(const WallScene& scene, const GeneratedFunction& function, Built* built) {
  double brightest_seen = 0.0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (function.seen[p]) brightest_seen = std::max(brightest_seen, double{function.phi[p]});
  }
  for (int p = 0; p < kSupportPointCount; ++p) {
    const double phi = function.phi[p];
    built->outside_range += !(phi >= 0.0 && phi <= 1.0) || (function.valid[p] == 0 && phi != 0.0);
    built->valid += function.valid[p];
    built->seen += function.seen[p];
    built->off_tent += scene.plain(pointAt(p)) && function.phi[p] != tent(pointAt(p));
    if (!(phi > 0.0)) continue;
    ++built->lit;
    built->lit_in_dark += scene.dark(pointAt(p));
    if (function.seen[p]) continue;
    ++built->lit_occluded;
    built->too_bright += phi > brightest_seen;
    built->brightest_occluded = std::max(built->brightest_occluded, phi);
  }
}

// Builds the function at the origin, which must be one; free space would say that the wall was missed.
bool buildAtOrigin(const WallScene& scene, StabilityFigures* figures, GeneratedFunction* function, Built* built) {
  const Scene finished = scene.faces.finish();
  const RayScene rays(finished);
  WeightingBuilder builder(rays, scene.diffusion);
  const bool is_function = builder.build(-finished.origin_m, 1.0f, function) == ProbeOutcome::function;
  figures->require(is_function, "a probe has no function");
  if (is_function) countLight(scene, *function, built);
  return is_function;
}

// The functions of some scenes, all of which must hold.
void measureWalls(const StabilityInputs& inputs, const std::vector<WallScene>& scenes, StabilityFigures* figures) {
  Built built;
  WorstBake worst;
  for (const WallScene& scene : scenes) {
    GeneratedFunction function;
    if (!buildAtOrigin(scene, figures, &function, &built)) continue;
    const SampledFunction stored =
        sampleFunction([&](int p) { return function.phi[p]; }, [&](int p) { return function.valid[p] != 0; });
    worst.addAll(inputs, stored.view(), ErrorBound::best_known);
  }
  figures->atLeast("points_seen", double(built.seen), 1);
  figures->show("points_lit_by_diffusion", double(built.lit_occluded));
  figures->show("brightest_occluded", built.brightest_occluded);
  figures->equals("points_outside_range", double(built.outside_range), 0);
  figures->equals("points_lit_in_the_dark", double(built.lit_in_dark), 0);
  figures->equals("points_in_plain_sight_without_the_tent", double(built.off_tent), 0);
  figures->equals("occluded_points_brighter_than_all_seen", double(built.too_bright), 0);
  worst.report(figures);
}

StabilityCase wallCase(const std::string& name, const std::function<std::vector<WallScene>()>& make) {
  return {
      "functions", name,
      "phi is in [0, 1] and 0 in solid, nothing behind the wall is lit, what stands in plain sight has the tent, nothing "
      "occluded is brighter than what is seen; what a bake stores is finite, no stage makes it worse, and its error is at most "
      "what the check allows, or 1.5 times the best known of the function in that representation",
      [make](const StabilityInputs& inputs, StabilityFigures* figures) { measureWalls(inputs, make(), figures); }};
}

// Nearer to a wall's face than this share of the spacing a point is in no plain sight.
constexpr double kGrazing = 1e-3;

// An endless wall from `near` to `far` along a normal that is turned about y from x; of both sides where it has no thickness.
WallScene slab(double near, double far, double degrees) {
  WallScene scene;
  const double angle = degrees * std::numbers::pi / 180.0;
  if (near < far) {
    scene.faces.addBox({near, -50, -50}, {far, 50, 50});
  } else {
    scene.faces.addQuad({near, -50, -50}, {near, 50, -50}, {near, 50, 50}, {near, -50, 50}, true);
  }
  for (glm::dvec3& at : scene.faces.positions) {
    at = {at.x * std::cos(angle) - at.z * std::sin(angle), at.y, at.x * std::sin(angle) + at.z * std::cos(angle)};
  }
  const auto height = [=](const LocalPoint& p) { return p[0] * std::cos(angle) + p[2] * std::sin(angle); };
  scene.dark = [=](const LocalPoint& p) { return height(p) > far + 1e-4; };
  scene.plain = [=](const LocalPoint& p) { return height(p) < near - kGrazing; };
  return scene;
}

WallScene sheet(double distance, double degrees) { return slab(distance, distance, degrees); }

// Two walls that meet in an edge, the probe at this distance from both.
WallScene corner(double distance) {
  WallScene scene;
  const double far = distance + 0.2;
  scene.faces.addBox({distance, -50, -50}, {far, 50, 50});
  scene.faces.addBox({-50, -50, distance}, {distance, 50, far});
  scene.dark = [=](const LocalPoint& p) { return std::max(p[0], p[2]) > far + 1e-4; };
  scene.plain = [=](const LocalPoint& p) { return std::max(p[0], p[2]) < distance - kGrazing; };
  return scene;
}

// A sheet with a slit of this width along y, its middle off every axis.
WallScene slit(double width) {
  WallScene scene;
  const double low = 0.1, high = 0.1 + width, x = 0.31;
  const auto half = [&](double from, double to) {
    scene.faces.addQuad({x, -50, from}, {x, -50, to}, {x, 50, to}, {x, 50, from}, true);
  };
  scene.plain = [=](const LocalPoint& p) { return p[0] < x - kGrazing; };
  half(-50, low);
  half(high, 50);
  return scene;
}

// A wall with a doorway, and a door in it that stands ajar by this angle: a sheet on hinges at the doorway's side. The probe stands
// before it and looks through the gap.
WallScene doorAjar(double degrees) {
  WallScene scene;
  constexpr double kNear = 0.31, kFar = 0.41, kHinge = -0.3, kWidth = 0.6;
  scene.faces.addBox({kNear, -50, -50}, {kFar, 50, kHinge});
  scene.faces.addBox({kNear, -50, kHinge + kWidth}, {kFar, 50, 50});
  const double angle = degrees * std::numbers::pi / 180.0, x = kFar + kWidth * std::sin(angle),
               z = kHinge + kWidth * std::cos(angle);
  scene.faces.addQuad({kFar, -50, kHinge}, {x, -50, z}, {x, 50, z}, {kFar, 50, kHinge}, true);
  scene.plain = [](const LocalPoint& p) { return p[0] < kNear - kGrazing; };
  return scene;
}

// A wall that ends at the height of the probe, and diffusion as far as its options go.
WallScene wrapAround(int passes, double sigma, double falloff) {
  WallScene scene;
  scene.faces.addBox({0.31, -50, -50}, {0.35, 0.0, 50});
  scene.plain = [](const LocalPoint& p) { return p[0] < 0.31 - kGrazing || p[1] > kGrazing; };
  scene.diffusion = {passes, sigma, falloff};
  return scene;
}

}  // namespace

std::vector<StabilityCase> wallCases() {
  using Scenes = std::vector<WallScene>;
  return {
      wallCase("wall along an axis", [] { return Scenes{slab(0.31, 0.47, 0.0)}; }),
      wallCase("wall at 1 degree from an axis", [] { return Scenes{slab(0.31, 0.47, 1.0)}; }),
      wallCase("walls that meet in a corner a hair from the probe (.05, 1e-3, 1e-5 of the spacing)",
               [] {
                 return Scenes{corner(0.05), corner(1e-3), corner(1e-5)};
               }),
      wallCase("sheet a hair from the probe (1e-3, 1e-5 of the spacing), at 0, 1 and 45 degrees",
               [] {
                 Scenes scenes;
                 for (const double distance : {1e-3, 1e-5}) {
                   for (const double degrees : {0.0, 1.0, 45.0}) scenes.push_back(sheet(distance, degrees));
                 }
                 return scenes;
               }),
      wallCase("wall thinner than any link (1e-5 of the spacing)",
               [] {
                 return Scenes{slab(0.31, 0.31001, 0.0), slab(0.31, 0.31001, 1.0)};
               }),
      wallCase("slit narrower than the points are apart",
               [] {
                 return Scenes{slit(0.01), slit(0.001), slit(1e-5)};
               }),
      wallCase("door that stands ajar by 2, 10 and 45 degrees",
               [] {
                 return Scenes{doorAjar(2.0), doorAjar(10.0), doorAjar(45.0)};
               }),
      wallCase("largest diffusion round a wall's end",
               [] {
                 return Scenes{wrapAround(2, 0.1, 2.0), wrapAround(16, 0.1, 2.0), wrapAround(16, 10.0, 1e6),
                               wrapAround(16, 1e-3, 0.0)};
               }),
  };
}

}  // namespace nlg
