// The scenes made by hand, by name.
#pragma once

#include <vector>

#include "tests/datagen/hand_built_scenes.h"

namespace nlg {

struct NamedScene {
  const char* name;
  Scene scene;
};

inline std::vector<NamedScene> namedScenes() {
  return {{"infinite wall", infiniteWall()},
          {"half wall", halfWall()},
          {"wall with a hole", wallWithHole()},
          {"thin wall", thinWall(Sides::one)},
          {"thin double-sided wall", thinWall(Sides::two)},
          {"slivers", slivers()},
          {"room", SceneOfFaces().addRoom({-0.4f, -0.5f, -0.6f}, {0.7f, 0.45f, 0.55f}, 0.2f).finish()},
          {"crate", SceneOfFaces().addBox({-0.3f, -0.9f, 0.25f}, {0.35f, -0.2f, 0.8f}).finish()},
          {"terrain", terrainSheet(-0.3f, Sides::one)},
          {"boxes that cross", crossingBoxes()},
          {"crate with a fin", crateWithFin()}};
}

}  // namespace nlg
