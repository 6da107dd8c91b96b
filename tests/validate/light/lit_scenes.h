// Scenes whose light is known, with probes and all that methods are made from.
#pragma once

#include "datagen/probes/probe_placement.h"
#include "light/air.h"
#include "light/air_places.h"
#include "light/light_transport.h"
#include "light/methods/method_set.h"
#include "tests/datagen/hand_built_scenes.h"
#include "validate/light/light_places.h"

namespace nlg {

// Light of its own on every vertex: what leaves a face is this times the base colour of 1/2, and one ray holds it all.
inline void lightVertices(Scene* scene, const std::vector<glm::vec3>& radiance) {
  BakedLight& baked = scene->light.baked;
  baked.triangle_page.assign(scene->triangles.size(), BakedLight::kByVertex);
  baked.vertex_place.assign(scene->positions.size(), glm::vec2(0.0f));
  for (const glm::vec3& light : radiance) baked.vertex_light.push_back(2.0f * light);
}

// A closed room, its walls inside and outside, and the sky around it: wherever one looks the radiance is 1.
inline Scene furnace() {
  SceneOfFaces faces;
  faces.addRoom({-2, -1, -2}, {2, 2, 2}, 0.2f);
  faces.addBox({-0.7f, -1, -0.3f}, {0.1f, 0.3f, 0.6f});
  Scene scene = faces.finish();
  lightVertices(&scene, std::vector<glm::vec3>(scene.positions.size(), glm::vec3(1.0f)));
  scene.light.sky = {glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
  return scene;
}

// Two rooms of 3 m with a wall of 10 cm between them, at x = 0.4. The one at low x shines, the other is dark.
inline constexpr float kWallLow = 0.35f, kWallHigh = 0.45f;
inline Scene brightAndDarkRoom() {
  SceneOfFaces faces;
  faces.addBox({kWallLow - 3.0f, 0, 0}, {kWallLow, 3, 3}, true);
  faces.addBox({kWallHigh, 0, 0}, {kWallHigh + 3.0f, 3, 3}, true);
  faces.addBox({kWallLow - 3.1f, -0.1f, -0.1f}, {kWallHigh + 3.1f, 3.1f, 3.1f});
  Scene scene = faces.finish();
  std::vector<glm::vec3> radiance;
  for (const glm::vec3& position : scene.positions) radiance.push_back(glm::vec3(position.x <= kWallLow ? 1.0f : 0.0f));
  lightVertices(&scene, radiance);
  return scene;
}

struct LitScene {
  explicit LitScene(Scene made, double spacing_m = 1.0)
      : scene(std::move(made)),
        rays(scene),
        transport(scene, rays),
        tree(placeProbes(scene, placement(spacing_m), 1)),
        air(findAirPlaces(rays, tree, {}, 1)) {}

  static ProbePlacementOptions placement(double spacing_m) {
    ProbePlacementOptions options;
    options.spacing_min_m = options.spacing_max_m = spacing_m;
    return options;
  }

  LightPlaces places() const {
    LightPlaceOptions options;
    options.air = 200;
    options.surface = 200;
    options.walks = 4;
    return drawLightPlaces(scene, rays, lightExtent(scene, {}), options);
  }
  MethodSet methods() const {
    MethodSetOptions options;
    options.probe.rays = 256;
    return MethodSet({transport, tree, air}, options);
  }

  Scene scene;
  RayScene rays;
  LightTransport transport;
  ProbeTree tree;
  AirPlaces air;
};

}  // namespace nlg
