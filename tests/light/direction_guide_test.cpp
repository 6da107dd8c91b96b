#include "light/direction_guide.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "light/directions.h"
#include "light/light_transport.h"
#include "runtime_eval/numbers/random.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

constexpr int kRays = 256;

// Every place's rays meet this radiance.
template <class Radiance>
DirectionGuide taught(int places, const Radiance& radiance) {
  DirectionGuide guide;
  for (int place = 0; place < places; ++place) {
    const Lattice lattice(3, static_cast<uint64_t>(place));
    for (int i = 0; i < kRays; ++i) {
      const auto [u, v] = lattice.point(i, kRays);
      const DirectionGuide::Drawn drawn = guide.draw(u, v);
      guide.learn(drawn.bin, radiance(drawn.direction));
    }
    guide.endPlace();
  }
  return guide;
}

// A bright window of a hundredth of the sphere, in a dim room.
bool isWindow(const glm::vec3& direction) { return glm::dot(direction, glm::normalize(glm::vec3(1, 2, 0.5f))) > 0.98f; }
float windowLight(const glm::vec3& direction) { return isWindow(direction) ? 10.0f : 0.05f; }

TEST(DirectionGuide, BeginsEven) {
  const DirectionGuide guide;
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const DirectionGuide::Drawn drawn = guide.draw(random.uniform(), random.uniform());
    EXPECT_NEAR(drawn.density, 0.25 / std::numbers::pi, 1e-6);
    EXPECT_NEAR(glm::length(drawn.direction), 1.0f, 1e-5f);
  }
}

TEST(DirectionGuide, DensityIsThatOfWhatItDraws) {
  const DirectionGuide guide = taught(20, windowLight);
  Random random(5);
  double integral = 0.0, inverse = 0.0;
  int disagreeing = 0;
  constexpr int kCount = 200000;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.uniform(), v = random.uniform();
    integral += guide.density(sphereDirection(u, v)) * 4.0 * std::numbers::pi / kCount;
    const DirectionGuide::Drawn drawn = guide.draw(u, v);
    disagreeing += std::fabs(guide.density(drawn.direction) / drawn.density - 1.0) > 1e-4;
    inverse += 1.0 / drawn.density / kCount;
  }
  EXPECT_NEAR(integral, 1.0, 0.02);
  EXPECT_NEAR(inverse, 4.0 * std::numbers::pi, 0.1);
  // but for directions that rounding takes over a bin's edge
  EXPECT_LT(disagreeing, kCount / 1000);
}

TEST(DirectionGuide, SendsRaysToTheWindowAndLeavesHalfEven) {
  const DirectionGuide guide = taught(20, windowLight);
  int through = 0;
  float least = INFINITY;
  const Lattice lattice(9, 0);
  constexpr int kCount = 4096;
  for (int i = 0; i < kCount; ++i) {
    const auto [u, v] = lattice.point(i, kCount);
    const DirectionGuide::Drawn drawn = guide.draw(u, v);
    through += isWindow(drawn.direction);
    least = std::min(least, drawn.density);
  }
  // a hundredth of even rays
  EXPECT_GT(through, kCount / 20);
  EXPECT_GE(least, 0.49f * 0.25f / std::numbers::pi_v<float>);
}

TEST(DirectionGuide, StaysEvenInTheDark) {
  const DirectionGuide guide = taught(5, [](const glm::vec3&) { return 0.0f; });
  EXPECT_NEAR(guide.density({0, 0, 1}), 0.25 / std::numbers::pi, 1e-6);
}

// A room with a window in its ceiling under an even sky: the mean is that without a guide, its noise less.
TEST(DirectionGuide, PlacesMeasureTheSameLightWithLessNoise) {
  SceneOfFaces faces;
  faces.addBox({-3.2f, -0.2f, -3.2f}, {3.2f, 0, 3.2f});
  for (const float side : {-3.2f, 3.0f}) {
    faces.addBox({side, 0, -3.2f}, {side + 0.2f, 3, 3.2f});
    faces.addBox({-3, 0, side}, {3, 3, side + 0.2f});
  }
  // the ceiling: four beams round a window of .6 m
  faces.addBox({-3.2f, 3, -3.2f}, {1.0f, 3.2f, 3.2f});
  faces.addBox({1.6f, 3, -3.2f}, {3.2f, 3.2f, 3.2f});
  faces.addBox({1.0f, 3, -3.2f}, {1.6f, 3.2f, 1.0f});
  faces.addBox({1.0f, 3, 1.6f}, {1.6f, 3.2f, 3.2f});
  Scene scene = faces.finish();
  scene.materials[0].base_color = glm::vec3(0.2f);
  scene.light.sky.zenith = scene.light.sky.horizon = scene.light.sky.ground = glm::vec3(1.0f);
  const RayScene rays(scene);
  const LightTransport transport(scene, rays);
  const GatherOptions options{128, 64};
  const glm::dvec3 place(-1.5, 1.0, -1.0);
  const double truth = transport.gather(place, {1 << 16, 64}, 1).light[0].g;
  ASSERT_GT(truth, 0.0);
  constexpr int kPlaces = 400;
  const auto errors = [&](DirectionGuide* guide) {
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < kPlaces; ++i) {
      const double error =
          transport.gather(place, options, mixSeed(7, static_cast<uint64_t>(i)), 0, guide).light[0].g / truth - 1.0;
      sum += error;
      squares += error * error;
    }
    return std::pair{sum / kPlaces, std::sqrt(squares / kPlaces)};
  };
  DirectionGuide guide;
  const auto [even_mean, even_noise] = errors(nullptr);
  const auto [guided_mean, guided_noise] = errors(&guide);
  EXPECT_LT(guided_noise, 0.7 * even_noise);
  EXPECT_LT(std::fabs(guided_mean), 4.0 * guided_noise / std::sqrt(kPlaces) + 0.005);
}

}  // namespace
}  // namespace nlg
