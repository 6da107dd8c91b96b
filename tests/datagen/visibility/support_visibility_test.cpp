#include "datagen/visibility/support_visibility.h"

#include <gtest/gtest.h>

#include "tests/datagen/named_scenes.h"
#include "tests/runtime_eval/each_target.h"

namespace nlg {
namespace {

TEST(SupportVisibility, FindsWhatAnyEyeSeesAsTheDefinitionDoesOnEveryTarget) {
  const std::vector<LocalPoint>& points = supportPattern().points;
  // eyes anywhere in the support; one lies in the plane of a wall, one is a support point, one is all but on a face
  const std::vector<LocalPoint> eyes = {{0.0f, 0.0f, 0.0f},   {0.55f, -0.4f, 0.3f},   {-0.93f, 0.11f, -0.97f},
                                        {0.31f, 0.2f, -0.6f}, points[4321],           {0.3100001f, 0.9f, 0.1f},
                                        {0.2f, -0.13f, 0.0f}, {-0.01f, 0.02f, 0.015f}};
  for (const NamedScene& named : namedScenes()) {
    const RayScene scene(named.scene);
    SupportVisibility visibility(scene);
    visibility.beginProbe(glm::dvec3(0), 1.0f);
    forEachTarget([&] {
      for (const LocalPoint& eye : eyes) {
        visibility.traceRays(eye);
        std::vector<bool> is_dark(points.size(), false);
        visibility.forEachDark([&](uint32_t point) { is_dark[point] = true; });
        for (uint32_t p = 0; p < points.size(); ++p)
          ASSERT_EQ(!is_dark[p], visibility.isOpen(eye, points[p]))
              << named.name << ", eye " << eye[0] << ' ' << eye[1] << ' ' << eye[2] << ", point " << p;
      }
    });
  }
}

}  // namespace
}  // namespace nlg
