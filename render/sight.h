// Geometry that the samples of a picture see, before light is known: the same for all methods.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "light/light_transport.h"
#include "light/methods/light_method.h"
#include "render/camera.h"

namespace nlg {

struct Sight {
  enum class Kind : uint8_t {
    receiver,    // a surface or a ball: what arrives at `receiver` decides its brightness
    background,  // sky, or nothing
    solid,       // of a cut: in no air
  };
  Kind kind = Kind::background;
  Receiver receiver;
  glm::vec3 albedo{0.0f};
  glm::vec3 shine{0.0f};  // radiance beside what is reflected: emission, sky
};

// Samples of all pixels, row by row from the top, those of a pixel one after another.
struct Sights {
  int width = 0, height = 0, samples_per_pixel = 1;
  std::vector<Sight> samples;
};

// A ball that hangs in the air: lit by what arrives at its centre for the normal of its surface, as engines light small things by
// a light grid. It throws no shadow.
struct Ball {
  glm::dvec3 centre_m{0.0};  // relative to the scene's origin
  double radius_m = 0.1;     // > 0
};

inline constexpr float kBallAlbedo = 0.3f;  // as bright as walls: an exposure for these cuts no ball off

struct SightOptions {
  int width = 640, height = 360;
  int samples_per_side = 2;  // n x n samples of a pixel, at the centres of n x n squares
  double offset_m = 0.02;    // light is asked for so far before a surface, or half way to what stands nearer before it
  std::vector<Ball> balls;
  int thread_count = 1;
};

// What a camera sees.
Sights sightsOf(const LightTransport& transport, const Camera& camera, const SightOptions& options);

// A horizontal cut through a scene.
struct Cut {
  glm::dvec3 low_m{0.0}, high_m{0.0};  // relative to the scene's origin; the cut's height is low_m.y
};

// Light on a plane that faces up, at the centre of every pixel, as on white paper: albedo 1. Seen from above: x to the right, z down.
// The height in pixels follows from the width.
Sights sightsOfCut(const LightTransport& transport, const Cut& cut, int width, int thread_count);

}  // namespace nlg
