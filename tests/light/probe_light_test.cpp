#include "light/probe_light.h"

#include <gtest/gtest.h>

#include "datagen/probes/probe_placement.h"
#include "light/air_places.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

LightSh uniformLight(float value) {
  LightSh light{};
  light[0] = glm::vec3(value);
  return light;
}

// A closed room, its probes with bare tents, and light that the test makes up.
struct TentRoom {
  TentRoom() : scene(makeScene()), rays(scene), transport(scene, rays) {
    ProbePlacementOptions options;
    options.spacing_min_m = options.spacing_max_m = 1.0;
    const ProbeTree full = placeProbes(scene, options, 1);
    air = findAirPlaces(rays, full, {}, 2);
    tree = treeOfAir(full, air);
  }
  static Scene makeScene() {
    SceneOfFaces faces;
    faces.addRoom({-2.5f, -1.5f, -2.5f}, {2.5f, 1.5f, 2.5f}, 0.2f);
    return faces.finish();
  }
  WeightsAt tents() const {
    return [this](const glm::dvec3& p, ProbeWeights* weights) {
      ProbesAround around;
      weights->count = 0;
      if (!tree.lookUp({p.x, p.y, p.z}, &around)) return;
      for (const ProbeAround& corner : around.corners) {
        weights->probe[weights->count] = corner.probe;
        weights->weight[weights->count++] = tent(corner.local) * corner.tent_ratio;
      }
    };
  }
  ProbeLight solved(const std::vector<LightSh>& place_light, const ProbeLightOptions& options, int threads = 2) const {
    return lightProbes(transport, tree, air.places, place_light, tents(), options, threads);
  }

  Scene scene;
  RayScene rays;
  LightTransport transport;
  ProbeTree tree;
  AirPlaces air;
};

TEST(ProbeLight, IsTheLightOfPlacesWhereAllHaveTheSame) {
  const TentRoom room;
  const ProbeLight lit = room.solved(std::vector<LightSh>(room.air.places.size(), uniformLight(2.0f)), {});
  for (const LightSh& light : lit.light) EXPECT_NEAR(light[0].g, 2.0f, 1e-4f);
}

// One place in a thousand stands beside a lamp: with squared errors all probes around it rise far above what the places between
// them have, and with Cauchy's loss they do not.
TEST(ProbeLight, IsNotRuledByOnePlaceBesideALamp) {
  const TentRoom room;
  std::vector<LightSh> place_light(room.air.places.size(), uniformLight(1.0f));
  place_light[place_light.size() / 2] = uniformLight(200.0f);
  const auto largest = [&](double outlier) {
    ProbeLightOptions options;
    options.outlier = outlier;
    options.pull = 1e-3;  // the prior is a mean over places, that beside the lamp among them
    float value = 0.0f;
    for (const LightSh& light : room.solved(place_light, options).light) value = std::max(value, light[0].g);
    return value;
  };
  const float squares = largest(1e6), cauchy = largest(1.0);
  EXPECT_GT(squares, 1.1f);
  EXPECT_LT(cauchy - 1.0f, 0.2f * (squares - 1.0f));
}

TEST(ProbeLight, IsTheSameForAnyNumberOfThreads) {
  const TentRoom room;
  std::vector<LightSh> place_light;
  for (size_t i = 0; i < room.air.places.size(); ++i) place_light.push_back(uniformLight(static_cast<float>(i % 7)));
  EXPECT_EQ(room.solved(place_light, {}, 1).light, room.solved(place_light, {}, 3).light);
}

}  // namespace
}  // namespace nlg
