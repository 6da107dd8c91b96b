#include "datagen/view/function_slice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "datagen/view/level_raster.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

// A function made of rules for every support point.
struct MadeFunction {
  std::vector<uint8_t> phi, validity, seen;

  MadeFunction(const std::function<double(const LocalPoint&)>& value, const std::function<PixelKind(const LocalPoint&)>& kind)
      : phi(kSupportPointCount), validity(kValidityByteCount), seen(kValidityByteCount) {
    for (int i = 0; i < kSupportPointCount; ++i) {
      const LocalPoint& point = supportPattern().points[i];
      const PixelKind what = kind(point);
      const auto bit = static_cast<uint8_t>(1 << i % 8);
      if (what == PixelKind::solid) continue;
      validity[i / 8] |= bit;
      if (what == PixelKind::seen) seen[i / 8] |= bit;
      phi[i] = static_cast<uint8_t>(std::lround(255 * value(point)));
    }
  }
  StoredFunction samples() const { return {phi.data(), validity.data(), seen.data()}; }
};

PixelKind alwaysSeen(const LocalPoint&) { return PixelKind::seen; }

glm::dvec3 localOf(const FunctionSlice& slice, size_t pixel) {
  const double x = static_cast<double>(pixel % slice.size), y = static_cast<double>(pixel / slice.size);
  return slice.plane.toLocal({2 * (x + 0.5) / slice.size - 1, 2 * (y + 0.5) / slice.size - 1});
}

TEST(PlaneView, PicturesAreTurnedAsTheirTitlesSay) {
  const glm::dvec3 local(0.1, 0.2, 0.3);
  EXPECT_EQ(planeView(2).fromLocal(local), glm::dvec2(0.1, -0.2));  // x right, y up
  EXPECT_EQ(planeView(1).fromLocal(local), glm::dvec2(0.1, 0.3));   // x right, z down
  EXPECT_EQ(planeView(0).fromLocal(local), glm::dvec2(0.3, -0.2));  // z right, y up
  for (int normal = 0; normal < 3; ++normal) {
    glm::dvec3 on_plane = local;
    on_plane[normal] = 0.0;
    EXPECT_EQ(planeView(normal).toLocal(planeView(normal).fromLocal(local)), on_plane);
  }
}

TEST(FunctionSlice, OfALinearFunctionIsExactButForRounding) {
  const auto value = [](const LocalPoint& p) { return 0.5 + 0.2 * p[0] - 0.15 * p[1] + 0.1 * p[2]; };
  const MadeFunction function(value, alwaysSeen);
  const std::vector<ViewTriangle> no_triangles;
  for (int normal = 0; normal < 3; ++normal) {
    const FunctionSlice slice = makeFunctionSlice(function.samples(), normal, 64, &no_triangles);
    for (size_t i = 0; i < slice.phi.size(); ++i) {
      const glm::dvec3 p = localOf(slice, i);
      ASSERT_EQ(slice.kind[i], PixelKind::seen);
      // half a step of 8 bits; and in the corners nothing falls below the lowest point, which stands up to 0.1 of slope 0.27 away
      EXPECT_NEAR(slice.phi[i], value({float(p.x), float(p.y), float(p.z)}), 0.03) << p.x << ", " << p.y << ", " << p.z;
    }
  }
}

TEST(FunctionSlice, CarriesNothingThroughAWall) {
  // 1 on this side of a sheet at x = 0.31, 0 behind it
  const auto behind = [](const LocalPoint& p) { return p[0] > 0.31f; };
  const MadeFunction function([&](const LocalPoint& p) { return behind(p) ? 0.0 : 1.0; },
                              [&](const LocalPoint& p) { return behind(p) ? PixelKind::diffused : PixelKind::seen; });
  const std::vector<ViewTriangle> sheet = trianglesNear(thinWall(Sides::two), glm::dvec3(0.0), 1.0, 1.2);
  const std::vector<ViewTriangle> nothing;
  int carried_count = 0;
  for (const int normal : {1, 2}) {
    const FunctionSlice slice = makeFunctionSlice(function.samples(), normal, 96, &sheet);
    const FunctionSlice blind = makeFunctionSlice(function.samples(), normal, 96, &nothing);
    for (size_t i = 0; i < slice.phi.size(); ++i) {
      const bool is_behind = localOf(slice, i).x > 0.31;
      ASSERT_EQ(slice.kind[i], is_behind ? PixelKind::diffused : PixelKind::seen) << localOf(slice, i).x;
      EXPECT_EQ(slice.phi[i], is_behind ? 0.0f : 1.0f) << localOf(slice, i).x;
      carried_count += blind.kind[i] != slice.kind[i];
    }
  }
  EXPECT_GT(carried_count, 0);  // without the sheet some pixels would have been on the wrong side
}

TEST(FunctionSlice, SaysWhereNoSupportPointIsInSight) {
  // a box smaller than the distance between points: nothing stands in it
  SceneOfFaces faces;
  faces.addBox({0.48f, 0.48f, -0.02f}, {0.52f, 0.52f, 0.02f});
  const std::vector<ViewTriangle> box = trianglesNear(faces.finish(), glm::dvec3(0.0), 1.0, 1.2);
  const MadeFunction function([](const LocalPoint&) { return 1.0; }, alwaysSeen);
  const FunctionSlice slice = makeFunctionSlice(function.samples(), 2, 200, &box);
  for (size_t i = 0; i < slice.kind.size(); ++i) {
    const glm::dvec3 p = localOf(slice, i);
    const bool is_inside = std::fabs(p.x - 0.5) < 0.02 && std::fabs(p.y - 0.5) < 0.02;
    EXPECT_EQ(slice.kind[i], is_inside ? PixelKind::unknown : PixelKind::seen) << p.x << ", " << p.y;
  }
}

TEST(FunctionSlice, WithoutGeometryShowsTheNearestPoint) {
  const MadeFunction function([](const LocalPoint& p) { return tent(p); },
                              [](const LocalPoint& p) { return p[1] > 0.5f ? PixelKind::solid : PixelKind::seen; });
  const FunctionSlice slice = makeFunctionSlice(function.samples(), 0, 48, nullptr);
  for (size_t i = 0; i < slice.kind.size(); ++i) {
    const glm::dvec3 p = localOf(slice, i);
    size_t nearest = 0;
    double best = 1e9;
    for (size_t k = 0; k < supportPattern().points.size(); ++k) {
      const LocalPoint& q = supportPattern().points[k];
      const glm::dvec3 offset = glm::dvec3(q[0], q[1], q[2]) - p;
      if (glm::dot(offset, offset) < best) best = glm::dot(offset, offset), nearest = k;
    }
    EXPECT_EQ(slice.kind[i] == PixelKind::solid, !function.samples().isValid(nearest));
    EXPECT_EQ(slice.phi[i], static_cast<float>(function.phi[nearest]) / 255.0f);
  }
}

TEST(MostTellingPlane, IsTheOneThatShowsTheDifference) {
  const auto missing = [](int axis) {
    return MadeFunction([](const LocalPoint& p) { return tent(p); },
                        [axis](const LocalPoint& p) {
                          // solid beside the planes normal to the two other axes
                          return std::fabs(p[axis]) < 0.15f && std::fabs(p[(axis + 1) % 3]) > 0.2f ? PixelKind::solid
                                                                                                   : PixelKind::seen;
                        });
  };
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(mostTellingPlane(missing(axis).samples()), axis);
}

TEST(MostTellingPlane, DoesNotLieWithinAWall) {
  for (int axis = 0; axis < 3; ++axis) {
    const MadeFunction walled([](const LocalPoint& p) { return tent(p); },
                              [axis](const LocalPoint& p) { return p[axis] < 0.15f ? PixelKind::solid : PixelKind::seen; });
    EXPECT_NE(mostTellingPlane(walled.samples()), axis);
  }
}

TEST(LevelFromAbove, HatchesWhatTheCutGoesThroughWithoutSeams) {
  SceneOfFaces faces;
  faces.addBox({0, -1, 0}, {16, 0, 16});   // ground
  faces.addBox({4, -0.5f, 4}, {8, 3, 8});  // a block that stands in it
  const std::vector<ViewTriangle> triangles = trianglesNear(faces.finish(), glm::dvec3(0.0), 1.0, 1e6);
  const LevelMap map{{0.0, 0.0}, 4.0, 64, 64};  // diagonals run exactly through the samples
  const Image picture = drawLevel(triangles, map, -1.0, 1.0);
  const auto brightness = [](Colour colour) { return colour.r + colour.g + colour.b; };
  // where two triangles of the ground meet, and where none does, it looks the same
  const Colour ground = picture.at(0, 0);
  EXPECT_NE(ground, kMapGround) << "nothing was drawn";
  // stripes at 45 degrees, of two colours darker than the ground: a pixel of the cut is what its diagonal is
  std::map<int, Colour> diagonals;
  std::set<int> brightnesses;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool is_block = x >= 16 && x < 32 && y >= 16 && y < 32;
      if (!is_block) {
        EXPECT_EQ(picture.at(x, y), ground) << x << ", " << y;
        continue;
      }
      const auto diagonal = diagonals.try_emplace(x + y, picture.at(x, y)).first;
      EXPECT_EQ(picture.at(x, y), diagonal->second) << x << ", " << y;
      EXPECT_LT(brightness(picture.at(x, y)), brightness(ground)) << x << ", " << y;
      brightnesses.insert(brightness(picture.at(x, y)));
    }
  }
  EXPECT_EQ(brightnesses.size(), 2u);
  int changes = 0;
  for (int sum = 33; sum <= 62; ++sum) changes += !(diagonals.at(sum) == diagonals.at(sum - 1));
  EXPECT_GE(changes, 4) << "31 diagonals show two stripes at least";
}

TEST(LevelFromAbove, CutsAboveTheGroundAndBelowTheRoof) {
  SceneOfFaces faces;
  faces.addBox({0, -6, 0}, {16, 0, 16});
  faces.addRoom({2, 0, 2}, {14, 4, 14}, 0.5f);
  const std::vector<ViewTriangle> triangles = trianglesNear(faces.finish(), glm::dvec3(0.0), 1.0, 1e6);
  const LevelMap map = makeLevelMap({0, -6, 0}, {16, 4.5, 16}, 400);
  const double height = mostTellingHeight(triangles, map, -6.0, 4.5);
  EXPECT_GT(height, 0.0);
  EXPECT_LT(height, 4.0);
}

}  // namespace
}  // namespace nlg
