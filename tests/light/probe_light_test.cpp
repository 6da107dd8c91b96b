#include "light/probe_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "datagen/probes/probe_placement.h"
#include "light/air_places.h"
#include "runtime_eval/numbers/random.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {
namespace {

LightSh evenLight(float value) {
  LightSh light{};
  light[0] = glm::vec3(value);
  return light;
}

// A closed room, its probes with bare tents, and light that the test makes up.
struct TentRoom {
  explicit TentRoom(Scene of = makeScene()) : scene(std::move(of)), rays(scene), transport(scene, rays) {
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
  // What every place has.
  template <class ValueAt>
  std::vector<LightSh> placeLight(const ValueAt& value_at) const {
    std::vector<LightSh> light;
    for (const glm::dvec3& place : air.places) light.push_back(evenLight(static_cast<float>(value_at(place))));
    return light;
  }
  double blendAt(const glm::dvec3& place, const std::vector<LightSh>& light) const {
    ProbeWeights weights;
    tents()(place, &weights);
    EXPECT_TRUE(normaliseWeights(&weights));
    double sum = 0.0;
    for (int j = 0; j < weights.count; ++j) sum += weights.weight[j] * light[weights.probe[j]][0].g;
    return sum;
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
  const ProbeLight lit = room.solved(std::vector<LightSh>(room.air.places.size(), evenLight(2.0f)), {});
  for (const LightSh& light : lit.light) EXPECT_NEAR(light[0].g, 2.0f, 1e-4f);
}

// A wall of two sheets, 30 cm apart and open below the floor, in a room that has light everywhere: the dark in the wall is nobody's to
// see, and the bare tents of probes before it, which reach into it, stay as bright as the room.
TEST(ProbeLight, IsNotDarkForAHollowWall) {
  SceneOfFaces faces;
  faces.addRoom({-2.5f, -1.5f, -2.5f}, {2.5f, 1.5f, 2.5f}, 0.2f);
  for (const float x : {-0.15f, 0.15f})
    faces.addQuad({x, -1.5f, -2.5f}, {x, 1.5f, -2.5f}, {x, 1.5f, 2.5f}, {x, -1.5f, 2.5f}, Sides::two);
  Scene scene = faces.finish();
  scene.cavity_m = 0.0;  // as where a hole makes air of it
  const TentRoom room(std::move(scene));
  const auto isHollow = [](const glm::dvec3& place) { return std::fabs(place.x) < 0.15; };
  const auto hollow = static_cast<size_t>(std::count_if(room.air.places.begin(), room.air.places.end(), isHollow));
  const ProbeLight lit = room.solved(room.placeLight([&](const glm::dvec3& place) { return isHollow(place) ? 0.0 : 1.0; }), {});
  ASSERT_GT(hollow, 50u);
  EXPECT_EQ(lit.unseen, hollow);
  for (const LightSh& light : lit.light) EXPECT_NEAR(light[0].g, 1.0f, 1e-3f);
}

// One place in a thousand stands beside a lamp: with squared errors all probes around it rise far above what the places between
// them have, and with Cauchy's loss they do not.
TEST(ProbeLight, IsNotRuledByOnePlaceBesideALamp) {
  const TentRoom room;
  std::vector<LightSh> place_light(room.air.places.size(), evenLight(1.0f));
  place_light[place_light.size() / 2] = evenLight(5.0f);
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

// Every other place reads its probes by a ten-thousandth of their weights and has ten times the light: those weights' sum is below a
// thousandth of what counts as sure, and the square of that is the say that such places have.
TEST(ProbeLight, IsNotRuledByPlacesThatHardlyReadAnything) {
  const TentRoom room;
  const std::vector<glm::dvec3>& places = room.air.places;
  std::vector<LightSh> place_light(places.size(), evenLight(1.0f));
  std::map<std::array<double, 3>, bool> is_stray;
  for (size_t i = 1; i < places.size(); i += 2) {
    place_light[i] = evenLight(10.0f);
    is_stray[{places[i].x, places[i].y, places[i].z}] = true;
  }
  const WeightsAt tents = room.tents();
  const WeightsAt strays = [&](const glm::dvec3& p, ProbeWeights* weights) {
    tents(p, weights);
    if (is_stray.count({p.x, p.y, p.z}) == 0) return;
    for (int j = 0; j < weights->count; ++j) weights->weight[j] *= 1e-4f;
  };
  const ProbeLight lit = lightProbes(room.transport, room.tree, places, place_light, strays, {}, 2);
  // of the mean that a probe is held at, strays and the tent's share of 1e-4 have as many thousandths of its weight at most
  for (const LightSh& light : lit.light) EXPECT_NEAR(light[0].g, 1.0f, 0.01f);
}

// Light of 1 in the mean, with half of the places' noise at .6 below it and half above: what probes hold must not lean to the side
// that an error in shares makes more of. In shares of what was measured the places below have 16 times the say of those above.
TEST(ProbeLight, IsNotDarkerForNoise) {
  const TentRoom room;
  Random random(5);
  const std::vector<LightSh> place_light = room.placeLight([&](const glm::dvec3&) { return random.uniform() < 0.5 ? 0.4 : 1.6; });
  double mean = 0.0, measured = 0.0;
  const std::vector<LightSh> light = room.solved(place_light, {}).light;
  for (const LightSh& of_probe : light) mean += of_probe[0].g / static_cast<double>(light.size());
  for (const LightSh& of_place : place_light) measured += of_place[0].g / static_cast<double>(place_light.size());
  EXPECT_NEAR(mean, measured, 0.1);
}

// One half of the room has a tenth of the other's light. A metre and more from the border the dark half is off by less than half as
// much where errors are taken in shares of the light there as where they are taken against the level's mean.
TEST(ProbeLight, SeesErrorsInSharesOfTheLightThere) {
  const TentRoom room;
  const double dark = 0.1;
  const std::vector<LightSh> place_light = room.placeLight([&](const glm::dvec3& place) { return place.x < 0.0 ? dark : 1.0; });
  const auto worst = [&](double dark_share) {
    ProbeLightOptions options;
    options.dark_share = dark_share;
    const std::vector<LightSh> light = room.solved(place_light, options).light;
    double largest = 0.0;
    for (const glm::dvec3& place : room.air.places) {
      if (place.x <= -1.0) largest = std::max(largest, std::abs(room.blendAt(place, light) / dark - 1.0));
    }
    return largest;
  };
  EXPECT_LT(worst(ProbeLightOptions{}.dark_share), 0.5 * worst(1e3));
}

// Light of 1 everywhere, measured with noise. Order 2 is held three times as hard.
TEST(ProbeLight, IsLessNoisyThanThePlacesThatItIsMadeOf) {
  const TentRoom room;
  Random random(3);
  std::vector<LightSh> place_light;
  double noise_of_places = 0.0;
  for (size_t i = 0; i < room.air.places.size(); ++i) {
    LightSh light = evenLight(1.0f);
    for (glm::vec3& value : light) value += glm::vec3(static_cast<float>(random.uniform(-0.2, 0.2)));
    noise_of_places += 0.04 / 3.0 / static_cast<double>(room.air.places.size());
    place_light.push_back(light);
  }
  const std::vector<LightSh> light = room.solved(place_light, {}).light;
  double mean_order = 0.0, second_order = 0.0;
  for (const LightSh& of_probe : light) {
    mean_order += std::pow(of_probe[0].g - 1.0, 2.0) / static_cast<double>(light.size());
    for (int k = 4; k < kShCount; ++k) second_order += std::pow(of_probe[k].g, 2.0) / 5.0 / static_cast<double>(light.size());
  }
  // with twelve places a cell least squares have .43 of a place's variance far from walls, and up to eight times that in corners,
  // where a probe has an eighth of the places; the pull takes from both
  EXPECT_LT(mean_order, noise_of_places);
  EXPECT_LT(second_order, 0.75 * mean_order);
}

// A lamp of 40 cm in the middle of a wall, and light of 1 elsewhere: beside it no place may become darker than that by a third.
TEST(ProbeLight, HasNoDarkRingAroundALamp) {
  const TentRoom room;
  const auto lampAt = [](const glm::dvec3& place) {
    const glm::dvec3 way = place - glm::dvec3(2.5, 0.0, 0.0);
    return 1.0 + 3.0 * 0.16 / (0.16 + glm::dot(way, way));
  };
  const std::vector<LightSh> light = room.solved(room.placeLight(lampAt), {}).light;
  for (const glm::dvec3& place : room.air.places)
    EXPECT_GT(room.blendAt(place, light), 2.0 / 3.0) << place.x << ' ' << place.y << ' ' << place.z;
}

}  // namespace
}  // namespace nlg
