// A scene made ready for pictures of it, and light that is known.
#pragma once

#include <algorithm>

#include "render/lit_picture.h"
#include "tests/datagen/hand_built_scenes.h"

namespace nlg {

struct Rendered {
  explicit Rendered(const Scene& s) : scene(s), rays(scene), transport(scene, rays) {}
  Scene scene;
  RayScene rays;
  LightTransport transport;
};

inline LightAt even(const glm::vec3& irradiance) {
  return [irradiance](std::span<const Receiver> receivers, LightAnswer* answers) {
    std::fill_n(answers, receivers.size(), LightAnswer{irradiance, Reach::lit});
  };
}

}  // namespace nlg
