#include "datagen/weighting/weighting_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/random.h"
#include "tests/datagen/named_scenes.h"

namespace nlg {
namespace {

const TestLinks& testLinks() {
  static const TestLinks links = makeTestLinks(testPoints(512));
  return links;
}

// Support points, then test points.
const std::vector<LocalPoint>& points() {
  static const std::vector<LocalPoint> all = [] {
    std::vector<LocalPoint> made = supportPattern().points;
    made.insert(made.end(), testLinks().points.begin(), testLinks().points.end());
    return made;
  }();
  return all;
}

struct Built {
  ProbeOutcome outcome;
  GeneratedFunction function;
};

Built build(const Scene& scene, const DiffusionOptions& options = {}, const glm::vec3& position_m = glm::vec3(0),
            float spacing_m = 1.0f, InSolid in_solid = InSolid::left_out) {
  const RayScene rays(scene);
  WeightingBuilder builder(rays, options, &testLinks());
  Built built;
  built.outcome = builder.build(position_m, spacing_m, &built.function, in_solid);
  return built;
}

std::vector<Scene> scenes() {
  std::vector<Scene> made;
  for (const NamedScene& named : namedScenes()) made.push_back(named.scene);
  return made;
}

struct Read {
  size_t point;
  double distance;
};

// The support points among the 32 that are nearest to a place: for a support point of all lattice cells' points, for others of the support's.
std::vector<Read> readBy(size_t p) {
  std::vector<Read> reads;
  const LocalPoint& at = points()[p];
  const bool is_support = p < kSupportPointCount;
  // a lattice of points goes on beyond the support; its octants repeat the positive one
  const int reach = is_support ? 1 : 0;
  for (int z = -reach - 1; z <= reach; ++z) {
    for (int y = -reach - 1; y <= reach; ++y) {
      for (int x = -reach - 1; x <= reach; ++x) {
        for (size_t i = 0; i < kOctantPointCount; ++i) {
          const LocalPoint& in_cell = points()[i];
          const double dx = double{in_cell[0]} + x - at[0], dy = double{in_cell[1]} + y - at[1],
                       dz = double{in_cell[2]} + z - at[2];
          const double distance = std::sqrt(dx * dx + dy * dy + dz * dz);
          if (distance == 0.0 || distance > 0.5) continue;
          const bool is_inside = std::min({x, y, z}) >= -1 && std::max({x, y, z}) <= 0;
          const size_t octant = (x < 0) | (y < 0) << 1 | (z < 0) << 2;
          reads.push_back({is_inside ? octant * kOctantPointCount + cellLinks().point_of[octant][i] : points().size(), distance});
        }
      }
    }
  }
  std::partial_sort(reads.begin(), reads.begin() + kLinkCount, reads.end(),
                    [](const Read& a, const Read& b) { return a.distance < b.distance; });
  reads.resize(kLinkCount);
  std::erase_if(reads, [](const Read& read) { return read.point == points().size(); });
  return reads;
}

const std::vector<std::vector<Read>>& allReads() {
  static const std::vector<std::vector<Read>> reads = [] {
    std::vector<std::vector<Read>> made;
    for (size_t p = 0; p < points().size(); ++p) made.push_back(readBy(p));
    return made;
  }();
  return reads;
}

// The definition, with every link tested and nothing left out: docs/theory/math.md §1.
std::vector<double> diffusedNaively(const Scene& scene, const GeneratedFunction& function, const DiffusionOptions& options) {
  const RayScene rays(scene);
  SupportVisibility visibility(rays);
  visibility.beginProbe(glm::dvec3(0), 1.0f);
  const size_t count = points().size();
  std::vector<double> phi(count, 0.0);
  std::vector<bool> lit(count, false);
  for (size_t p = 0; p < count; ++p) {
    lit[p] = function.seen[p];
    if (lit[p]) phi[p] = tent(points()[p]);
  }
  for (int pass = 0; pass < options.passes; ++pass) {
    const std::vector<double> phi_before = phi;
    const std::vector<bool> lit_before = lit;
    for (size_t p = 0; p < count; ++p) {
      if (!function.valid[p] || lit_before[p]) continue;
      double weighted = 0.0, lit_sum = 0.0, open_sum = 0.0;
      for (const Read& read : allReads()[p]) {
        if (!function.valid[read.point] || !visibility.isOpen(points()[p], points()[read.point])) continue;
        const double gaussian = std::exp(-0.5 * read.distance * read.distance / (options.sigma * options.sigma));
        open_sum += gaussian;
        if (lit_before[read.point]) lit_sum += gaussian, weighted += gaussian * phi_before[read.point];
      }
      if (lit_sum > 0) phi[p] = weighted / lit_sum * std::min(1.0, options.falloff * lit_sum / open_sum), lit[p] = true;
    }
  }
  return phi;
}

TEST(WeightingBuilder, FollowsTheDefinition) {
  for (const Scene& scene : scenes()) {
    for (const DiffusionOptions& options : {DiffusionOptions{}, DiffusionOptions{4, 0.05, 1.0}, DiffusionOptions{1, 3.0, 4.0}}) {
      const Built built = build(scene, options);
      ASSERT_EQ(built.outcome, ProbeOutcome::function);
      const std::vector<double> expected = diffusedNaively(scene, built.function, options);
      const GeneratedFunction& function = built.function;
      ASSERT_EQ(function.phi.size(), expected.size());
      for (size_t p = 0; p < expected.size(); ++p) {
        // phi is in [0, 1] and stored in float; Gaussians and what a pass reads are floats: a few roundings a pass
        ASSERT_NEAR(function.phi[p], expected[p], 8 * 0x1p-24 * (1 + options.passes))
            << "point " << p << ", sigma " << options.sigma;
        ASSERT_TRUE(function.phi[p] >= 0.0f && function.phi[p] <= 1.0f) << "point " << p << ": " << function.phi[p];
        ASSERT_TRUE(function.valid[p] <= 1 && function.seen[p] <= function.valid[p]) << "point " << p << " is seen in solid";
        ASSERT_TRUE(function.valid[p] || function.phi[p] == 0.0f) << "weight at invalid point " << p;
        ASSERT_TRUE(!function.seen[p] || function.phi[p] == tent(points()[p])) << "point " << p;
      }
    }
  }
}

TEST(WeightingBuilder, GivesAnyPlaceWhatItGivesTestPoints) {
  int in_shadow = 0;
  for (const Scene& scene : scenes()) {
    const RayScene rays(scene);
    for (const DiffusionOptions& options : {DiffusionOptions{}, DiffusionOptions{4, 0.05, 1.0}}) {
      WeightingBuilder builder(rays, options, &testLinks());
      GeneratedFunction function;
      ASSERT_EQ(builder.build(glm::dvec3(0), 1.0f, &function), ProbeOutcome::function);
      for (size_t p = kSupportPointCount; p < points().size(); ++p) {
        if (!function.valid[p]) continue;
        ASSERT_EQ(builder.sees(points()[p]), function.seen[p] != 0) << "point " << p;
        ASSERT_EQ(builder.valueAt(points()[p], function), function.phi[p]) << "point " << p;
        in_shadow += !function.seen[p] && function.phi[p] > 0.0f;
      }
    }
  }
  EXPECT_GT(in_shadow, 100);
}

TEST(WeightingBuilder, TellsFreeSpace) {
  const RayScene rays(infiniteWall());
  WeightingBuilder builder(rays, {}, &testLinks());
  GeneratedFunction function;
  EXPECT_EQ(builder.build({-3, 0, 0}, 2.0f, &function), ProbeOutcome::free_space);
  EXPECT_EQ(builder.build({-3, 0, 0}, 3.5f, &function), ProbeOutcome::function);
}

TEST(WeightingBuilder, LightsTheNearerSideOfAWallFromInsideIt) {
  const Built built = build(infiniteWall(), {}, {0.36f, 0.01f, 0.02f}, 1.0f, InSolid::by_eye);
  ASSERT_EQ(built.outcome, ProbeOutcome::function);
  EXPECT_TRUE(built.function.in_solid);
  for (size_t p = 0; p < built.function.phi.size(); ++p) {
    const LocalPoint& at = points()[p];
    const float x = 0.36f + at[0];
    ASSERT_EQ(built.function.phi[p], x < 0.31f ? tent(at) : 0.0f) << "point " << p << " at x = " << x;
    ASSERT_EQ(built.function.valid[p], x < 0.31f || x > 0.47f) << "point " << p << " at x = " << x;
  }
}

// Mirroring is exact in float, links are mirrored exactly, and closed solids need no vote of theirs that could differ.
void expectMirrored(const Scene& scene, const glm::vec3& position_m, InSolid in_solid) {
  const GeneratedFunction plain = build(scene, {}, position_m, 1.0f, in_solid).function;
  for (int mirror = 1; mirror < kMirrorCount; ++mirror) {
    glm::vec3 mirrored_position = position_m;
    for (int axis = 0; axis < 3; ++axis) mirrored_position[axis] *= (mirror >> axis) & 1 ? -1.0f : 1.0f;
    const GeneratedFunction mirrored = build(mirroredScene(scene, mirror), {}, mirrored_position, 1.0f, in_solid).function;
    for (int p = 0; p < kSupportPointCount; ++p) {
      const int image = p ^ (mirror * kOctantPointCount);
      ASSERT_EQ(mirrored.phi[image], plain.phi[p]) << "mirror " << mirror << ", point " << p;
      ASSERT_EQ(mirrored.valid[image], plain.valid[p]) << "mirror " << mirror << ", point " << p;
    }
  }
}

TEST(WeightingBuilder, MirrorsAFunctionWithItsScene) {
  for (const Scene& scene : {infiniteWall(), halfWall(), wallWithHole()}) expectMirrored(scene, glm::vec3(0), InSolid::left_out);
  // in solid one candidate, or one of several that see the same, is best on either side of these walls
  expectMirrored(infiniteWall(), {0.36f, 0.01f, 0.02f}, InSolid::by_eye);
  expectMirrored(terrainSheet(0.4f, Sides::one), glm::vec3(0), InSolid::by_eye);
}

TEST(WeightingBuilder, CreepsRoundTheEdgeOfAHalfWallAndDecays) {
  const GeneratedFunction none = build(halfWall(), {0, 0.1}).function, one = build(halfWall(), {1, 0.1}).function,
                          two = build(halfWall(), {2, 0.1}).function;
  double sum_one = 0.0, sum_two = 0.0;
  int count_one = 0, count_two = 0;
  for (size_t p = 0; p < two.phi.size(); ++p) {
    if (none.seen[p] || !two.valid[p]) continue;
    // a pass reads only what stood before it, and leaves alone what has weight
    if (one.phi[p] > 0) {
      ASSERT_EQ(two.phi[p], one.phi[p]) << "point " << p;
    }
    if (two.phi[p] == 0) continue;
    // an average, times at most 1: never more than the most that a neighbour has
    float most = 0.0f;
    for (const Read& read : allReads()[p]) most = std::max(most, two.phi[read.point]);
    ASSERT_LE(two.phi[p], most) << "point " << p;
    // two passes of the longest link reach no farther from what the probe sees
    (one.phi[p] > 0 ? sum_one : sum_two) += two.phi[p];
    ++(one.phi[p] > 0 ? count_one : count_two);
  }
  ASSERT_GT(count_one, 20) << "weight must creep round the edge";
  ASSERT_GT(count_two, 20);
  EXPECT_LT(sum_two / count_two, sum_one / count_one) << "the second ring must be darker than the first";
}

TEST(WeightingBuilder, IsTheSameAHundredKilometresAway) {
  Scene far = wallWithHole();
  far.origin_m = {1e5, -1e5, 3e4};
  const GeneratedFunction here = build(wallWithHole()).function, there = build(far).function;
  EXPECT_EQ(here.phi, there.phi);
  EXPECT_EQ(here.valid, there.valid);
}

TEST(WeightingBuilder, SeesNothingFromWithinASurface) {
  // sheets through the probe at 0 and 45 degrees, whose planes floats hold exactly, and a triangle with a corner in it
  for (const float x : {0.0f, 50.0f}) {
    const Scene sheet = SceneOfFaces().addQuad({x, -50, -50}, {x, 50, -50}, {-x, 50, 50}, {-x, -50, 50}, Sides::two).finish();
    EXPECT_EQ(build(sheet).outcome, ProbeOutcome::empty) << x;
  }
  const Scene corner = SceneOfFaces().addTriangle({0, 0, 0}, {0.5f, 0.3f, -0.4f}, {0.5f, 0.2f, 0.6f}, Sides::two).finish();
  EXPECT_EQ(build(corner).outcome, ProbeOutcome::empty);
}

// A room of 4 m with walls of 20 cm, a pillar and a low wall; share of its faces turned round, and left out.
Scene furnishedRoom(double flipped = 0.0, double missing = 0.0) {
  Scene scene = SceneOfFaces()
                    .addRoom({0, 0, 0}, {4, 3, 4}, 0.2f)
                    .addBox({1.3f, 0, 1.1f}, {1.72f, 3, 1.53f})
                    .addBox({2.41f, 0, 0}, {2.55f, 1.37f, 2.9f})
                    .finish();
  Random random(47);
  for (glm::uvec3& triangle : scene.triangles) {
    if (random.chance(flipped)) std::swap(triangle.y, triangle.z);
    if (random.chance(missing)) triangle = scene.triangles[0];
  }
  return scene;
}

std::vector<Built> functionsIn(const Scene& scene, float scale = 1.0f) {
  std::vector<Built> all;
  for (int i = 0; i < 8; ++i) {
    const glm::vec3 position_m(i & 1 ? 0.6f : 2.9f, i & 2 ? 0.7f : 2.2f, i & 4 ? 0.9f : 3.1f);
    all.push_back(build(scene, {}, scale * position_m, scale * 0.7f));
  }
  return all;
}

TEST(WeightingBuilder, MakesTheSameFunctionsOfARoomOfAnySize) {
  const std::vector<Built> wanted = functionsIn(furnishedRoom());
  for (const float scale : {0.00025f, 25000.0f}) {  // 1 mm, 100 km
    Scene scaled = furnishedRoom();
    for (glm::vec3& position : scaled.positions) position *= scale;
    const std::vector<Built> functions = functionsIn(scaled, scale);
    int apart = 0;
    for (size_t i = 0; i < wanted.size(); ++i) {
      ASSERT_EQ(functions[i].outcome, wanted[i].outcome);
      for (size_t p = 0; p < wanted[i].function.phi.size(); ++p) {
        apart += functions[i].function.valid[p] != wanted[i].function.valid[p] ||
                 std::fabs(functions[i].function.phi[p] - wanted[i].function.phi[p]) > 1.0f / 255;
      }
    }
    // rounding a position to float moves it by 6e-8 of its size: only points whose links graze an edge may change
    EXPECT_LE(apart, 1e-4 * 8 * kSupportPointCount) << scale;
  }
}

TEST(WeightingBuilder, DoesNotMindTrianglesThatAreThereTwice) {
  Scene twice = furnishedRoom();
  for (const glm::uvec3& triangle : furnishedRoom().triangles) twice.triangles.push_back(triangle);
  twice.triangle_material.resize(twice.triangles.size());
  const std::vector<Built> wanted = functionsIn(furnishedRoom()), functions = functionsIn(twice);
  for (size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_EQ(functions[i].function.phi, wanted[i].function.phi) << i;
    EXPECT_EQ(functions[i].function.valid, wanted[i].function.valid) << i;
  }
}

TEST(WeightingBuilder, IsSoundInRoomsOfFlippedAndMissingTriangles) {
  const Scene triangle = SceneOfFaces().addTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, Sides::two).finish();
  for (const Scene& scene : {furnishedRoom(1.0), furnishedRoom(0.5), furnishedRoom(0.0, 0.2), triangle}) {
    for (const auto& [outcome, function] : functionsIn(scene)) {
      for (size_t p = 0; p < function.phi.size(); ++p) {
        ASSERT_TRUE(function.phi[p] >= 0.0f && function.phi[p] <= 1.0f) << "point " << p << ": " << function.phi[p];
        ASSERT_TRUE(function.valid[p] || function.phi[p] == 0.0f) << "weight at invalid point " << p;
      }
    }
  }
}

}  // namespace
}  // namespace nlg
