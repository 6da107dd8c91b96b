// Draws one sample point: truth, a method's result, and the error, side by side.
//
// A grey ball hangs at the place, lit by what arrives at its centre, and a needle stands on it along the normal that was measured.
// The ball's colour at the needle's foot is the measured irradiance.
#pragma once

#include <cstdint>
#include <string>

#include "light/light_transport.h"
#include "render/camera.h"
#include "render/picture/image.h"
#include "render/sight.h"

namespace nlg {

struct PlaceView {
  Camera camera;
  Ball ball;
};

// Looks at a place from at most 3 m off, from the side that its normal points to: from where the way is free, the place is not
// seen at a grazing angle, and up stays up.
// place   in air
PlaceView viewOfPlace(const LightTransport& transport, const Receiver& place);

// What was measured there.
struct MeasuredPlace {
  std::string method;  // that answered
  Receiver at;
  glm::vec3 truth{0.0f}, answer{0.0f};  // irradiance
  double error = 0.0;                   // in shares of the scale
  double scale = 0.0;                   // truth's root mean square in the scene's air
};

struct PlacePictureOptions {
  int width = 220, height = 165;  // of each of the three
  int truth_rays = 64;            // of a pixel, >= 8; from 32 on they are those of four samples
  int thread_count = 1;
  uint64_t seed = 1;
};

// The exposure shows truth's median as middle grey, unless the ball would be cut off by it; it stands below the picture. The error's
// last colour stands for at least the error at the place.
// The same bits for any number of threads.
// light_at   what answered
Image drawPlace(const LightTransport& transport, const MeasuredPlace& place, const LightAt& light_at,
                const PlacePictureOptions& options);

}  // namespace nlg
