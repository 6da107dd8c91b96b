// Weighting functions that a builder makes beside walls, sheets and slits: where light may go, and what a bake stores of them.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "validate/stability/extreme_function.h"
#include "validate/stability/face_scene.h"

namespace nlg {
namespace {

struct WallScene {
  FaceScene faces;
  DiffusionOptions diffusion;
  // what the probe at the origin must never light: behind something that nothing leads around
  std::function<bool(const LocalPoint&)> dark = [](const LocalPoint&) { return false; };
  // what nothing stands before: seen from the probe, so that it has the tent exactly
  std::function<bool(const LocalPoint&)> plain = [](const LocalPoint&) { return false; };
};

// What was built at the origin with a spacing of 1 m, as figures.
struct Built {
  ProbeOutcome outcome = ProbeOutcome::empty;
  uint64_t outside_range = 0;  // points with phi that is not in [0, 1], or not 0 where invalid
  uint64_t unreachable = 0;    // lit points that lie more links from every seen one than there are passes
  uint64_t lit_in_dark = 0;    // lit points where nothing may be lit
  uint64_t off_tent = 0;       // points in plain sight without the tent
  uint64_t valid = 0, seen = 0, lit = 0, lit_occluded = 0;
  double brightest_occluded = 0.0, brightest_seen = 0.0;
  SampledFunction stored;
};

// By point: how many links it lies from what the probe sees, at most `passes`; more says passes + 1.
std::vector<int> linksFromSeen(const GeneratedFunction& function, int passes) {
  const LinkTable& links = stabilityLinks();
  std::vector<int> distance(kSupportPointCount, passes + 1);
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (function.seen[p]) distance[p] = 0;
  }
  for (int pass = 1; pass <= passes; ++pass) {
    for (int p = 0; p < kSupportPointCount; ++p) {
      const LinkTable::Edge* nearest = &links.nearest[size_t(p) * kLinkCount];
      const bool touches = std::any_of(nearest, nearest + kLinkCount, [&](const LinkTable::Edge& edge) {
        return edge.point < kSupportPointCount && distance[edge.point] < pass;
      });
      if (distance[p] > pass && touches) distance[p] = pass;
    }
  }
  return distance;
}

void countLight(const WallScene& scene, const GeneratedFunction& function, Built* built) {
  const std::vector<int> distance = linksFromSeen(function, scene.diffusion.passes);
  for (int p = 0; p < kSupportPointCount; ++p) {
    const double phi = function.phi[p];
    built->outside_range += !(phi >= 0.0 && phi <= 1.0) || (function.valid[p] == 0 && phi != 0.0);
    built->valid += function.valid[p];
    built->seen += function.seen[p];
    if (function.seen[p]) built->brightest_seen = std::max(built->brightest_seen, phi);
    built->off_tent += scene.plain(pointAt(p)) && function.phi[p] != tent(pointAt(p));
    if (!(phi > 0.0)) continue;
    ++built->lit;
    built->unreachable += distance[p] > scene.diffusion.passes;
    built->lit_in_dark += scene.dark(pointAt(p));
    if (function.seen[p]) continue;
    ++built->lit_occluded;
    built->brightest_occluded = std::max(built->brightest_occluded, phi);
  }
  built->stored = sampleFunction([&](int p) { return std::clamp<double>(function.phi[p], 0.0, 1.0); },
                                 [&](int p) { return function.valid[p] != 0; });
}

Built buildAtOrigin(const WallScene& scene) {
  const Scene finished = scene.faces.finish();
  const RayScene rays(finished);
  WeightingBuilder builder(rays, stabilityLinks(), scene.diffusion);
  GeneratedFunction function;
  Built built;
  built.outcome = builder.build(-finished.origin_m, 1.0f, &function);
  if (built.outcome == ProbeOutcome::function || built.outcome == ProbeOutcome::empty) countLight(scene, function, &built);
  return built;
}

constexpr const char* kWallMustHold =
    "phi is in [0, 1] and 0 in solid, nothing behind the wall is lit, no light goes more links from what the probe sees than "
    "there are passes, nothing occluded is brighter than what is seen; what a bake stores is finite, no stage makes it worse, "
    "and "
    "its error is at most the threshold tau, or 1.5 times the best known of the function in that representation";

// The functions of some scenes, all of which must hold.
StabilityResult measureWalls(const StabilityInputs& inputs, const std::vector<WallScene>& scenes) {
  StabilityResult result;
  result.holds = true;
  uint64_t lit_wrongly = 0, seen = 0, lit_occluded = 0;
  double brightest = 0.0;
  WorstBake worst;
  std::string outcomes;
  for (const WallScene& scene : scenes) {
    const Built built = buildAtOrigin(scene);
    outcomes += (outcomes.empty() ? "" : ", ") + std::string(outcomeName(built.outcome));
    const uint64_t wrong = built.outside_range + built.unreachable + built.lit_in_dark + built.off_tent;
    lit_wrongly += wrong;
    seen += built.seen;
    lit_occluded += built.lit_occluded;
    brightest = std::max(brightest, built.brightest_occluded);
    // free space says that the wall was missed: nothing would be measured then
    const bool is_found = built.outcome == ProbeOutcome::function && built.seen > 0;
    result.holds = result.holds && is_found && wrong == 0 && built.brightest_occluded <= built.brightest_seen;
    if (!is_found || inputs.generators.empty()) continue;
    worst.add(worstBake(inputs, built.stored.view(), ErrorBound::best_known));
    result.holds = result.holds && worst.holds();
  }
  result.measured = fmt::format("{}; {} points seen, {} lit by diffusion (brightest {:.3f}), {} lit wrongly", outcomes, seen,
                                lit_occluded, brightest, lit_wrongly);
  result.figures = {{"points_seen", double(seen)},
                    {"points_lit_by_diffusion", double(lit_occluded)},
                    {"points_lit_wrongly", double(lit_wrongly)},
                    {"brightest_occluded", brightest}};
  if (inputs.generators.empty()) return result;
  result.fails_check = worst.failing_count > 0;
  result.measured +=
      fmt::format("; worst RMSE of what a bake stores {:.4f} ({}), {}; at most {} of {} generators fail its check",
                  worst.stored_rmse, worst.stored_name, describeBound(worst), worst.failing_count, inputs.generators.size());
  result.figures["rmse_stored"] = worst.stored_rmse;
  result.figures["stored_over_bound"] = worst.most_of_bound;
  result.figures["failing_generators"] = worst.failing_count;
  return result;
}

// Probes that see nothing, for they stand in what is there: no function, and not one point lit.
StabilityResult measureBlind(const std::vector<WallScene>& scenes) {
  StabilityResult result;
  result.holds = true;
  uint64_t valid = 0, seen = 0, lit = 0;
  std::string outcomes;
  for (const WallScene& scene : scenes) {
    const Built built = buildAtOrigin(scene);
    outcomes += (outcomes.empty() ? "" : ", ") + std::string(outcomeName(built.outcome));
    // without valid points there is nothing that could be lit
    result.holds = result.holds && built.outcome == ProbeOutcome::empty && built.valid > 0;
    valid += built.valid;
    seen += built.seen;
    lit += built.lit;
  }
  result.holds = result.holds && seen == 0 && lit == 0;
  result.measured = fmt::format("{}; of {} points outside solid {} seen, {} lit", outcomes, valid, seen, lit);
  result.figures = {{"points_valid", double(valid)}, {"points_seen", double(seen)}, {"points_lit", double(lit)}};
  return result;
}

StabilityCase wallCase(const std::string& name, const std::function<std::vector<WallScene>()>& make) {
  return {"functions",           name,  kWallMustHold,
          StabilityDepth::brief, false, [make](const StabilityInputs& inputs) { return measureWalls(inputs, make()); }};
}

// Nearer to a wall's face than this share of the spacing a point is in no plain sight.
constexpr double kGrazing = 1e-3;

// A slab, endless as far as a support can tell: from `near` to `far` along a normal that is turned about y from x.
WallScene slab(double near, double far, double degrees) {
  WallScene scene;
  const double angle = degrees * M_PI / 180.0;
  const auto turned = [=](double along, double y, double across) {
    return glm::dvec3(along * std::cos(angle) - across * std::sin(angle), y, along * std::sin(angle) + across * std::cos(angle));
  };
  scene.faces.addBox({near, -50, -50}, {far, 50, 50});
  for (glm::dvec3& position : scene.faces.positions()) position = turned(position.x, position.y, position.z);
  const auto height = [=](const LocalPoint& p) { return p[0] * std::cos(angle) + p[2] * std::sin(angle); };
  scene.dark = [=](const LocalPoint& p) { return height(p) > far + 1e-4; };
  scene.plain = [=](const LocalPoint& p) { return height(p) < near - kGrazing; };
  return scene;
}

// A sheet without thickness, seen from both sides, at this distance from the probe.
WallScene sheet(double distance, double degrees) {
  WallScene scene;
  const double angle = degrees * M_PI / 180.0;
  const glm::dvec3 along(-std::sin(angle), 0, std::cos(angle)), up(0, 1, 0), to(std::cos(angle), 0, std::sin(angle));
  const auto at = [=](double u, double v) { return distance * to + u * along + v * up; };
  scene.faces.addQuad(at(-50, -50), at(50, -50), at(50, 50), at(-50, 50), FaceScene::Sides::two);
  const auto height = [=](const LocalPoint& p) { return p[0] * to.x + p[2] * to.z; };
  scene.dark = [=](const LocalPoint& p) { return height(p) > distance + 1e-4; };
  scene.plain = [=](const LocalPoint& p) { return height(p) < distance - kGrazing; };
  return scene;
}

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
    scene.faces.addQuad({x, -50, from}, {x, -50, to}, {x, 50, to}, {x, 50, from}, FaceScene::Sides::two);
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
  const double angle = degrees * M_PI / 180.0, x = kFar + kWidth * std::sin(angle), z = kHinge + kWidth * std::cos(angle);
  scene.faces.addQuad({kFar, -50, kHinge}, {x, -50, z}, {x, 50, z}, {kFar, 50, kHinge}, FaceScene::Sides::two);
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
      {"functions", "sheet at 0, 1 and 45 degrees and a corner, all through the probe itself",
       "a probe that stands in a surface is found to see nothing: it is empty, so that a bake stores no function of it, and no "
       "point on any side is lit",
       StabilityDepth::brief, false,
       [](const StabilityInputs&) {
         return measureBlind({sheet(0.0, 0.0), sheet(0.0, 1.0), sheet(0.0, 45.0), corner(0.0)});
       }},
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
