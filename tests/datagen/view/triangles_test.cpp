#include "datagen/view/function_slice.h"

#include <gtest/gtest.h>

#include <map>

#include "runtime_eval/numbers/random.h"
#include "scene/procedural/procedural.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

std::vector<ViewTriangle> everything(const Scene& scene) { return trianglesNear(scene, glm::dvec3(0.0), 1.0, 1e6); }

TEST(CutTriangles, ClosedSolidsGiveClosedLines) {
  // every end of a segment is the end of an even number of them, bit for bit
  for (const char* family : {"house", "maze", "outdoor"}) {
    const std::vector<ViewTriangle> triangles = everything(makeProceduralScene(family, 3));
    for (const double height : {0.111, 0.5, 1.2345}) {
      std::map<std::pair<double, double>, int> ends;
      for (const CutSegment& segment : cutTriangles(triangles, 1, height)) {
        ++ends[{segment.a.x, segment.a.z}];
        ++ends[{segment.b.x, segment.b.z}];
      }
      ASSERT_FALSE(ends.empty());
      for (const auto& [at, count] : ends)
        EXPECT_EQ(count % 2, 0) << family << " " << height << ": " << at.first << ", " << at.second;
    }
  }
}

TEST(TrianglesNear, KeepsWorldPrecisionAndLeavesOutTheFar) {
  SceneOfFaces faces;
  faces.addTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  faces.addTriangle({50, 0, 0}, {51, 0, 0}, {50, 1, 0});
  Scene scene = faces.finish();
  scene.origin_m = {100000.0, 0.0, -100000.0};
  const std::vector<ViewTriangle> near = trianglesNear(scene, {100000.25, 0.5, -100000.0}, 0.5, 1.0);
  ASSERT_EQ(near.size(), 1u);
  EXPECT_EQ(near[0].corners[1], glm::dvec3(1.5, -1.0, 0.0));
}

TEST(MayMeetBox, NeverMissesATriangleThatASegmentInTheBoxMeets) {
  Random random(7);
  const auto point = [&](double size) {
    return glm::dvec3(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size));
  };
  int met_count = 0;
  for (int i = 0; i < 20000; ++i) {
    const ViewTriangle triangle{{point(1.5), point(1.5), point(1.5)}, false};
    const glm::dvec3 a = point(0.5), b = point(0.5);
    if (!meetsTriangle(a, b, triangle)) continue;
    ++met_count;
    EXPECT_TRUE(mayMeetBox(triangle, glm::dvec3(-0.5), glm::dvec3(0.5))) << i;
  }
  EXPECT_GT(met_count, 500);
  const ViewTriangle corner{{glm::dvec3(2, 0, 0), glm::dvec3(0, 2, 0), glm::dvec3(0, 0, 2)}, false};
  EXPECT_FALSE(mayMeetBox(corner, glm::dvec3(-0.5), glm::dvec3(0.5)));  // its bounding box does, its plane does not
}

}  // namespace
}  // namespace nlg
