// A view of a scene for those who name none.
#pragma once

#include <vector>

#include "light/light_transport.h"
#include "render/camera.h"

namespace nlg {

// Looks from a place in air to where there is much to see: far and near, many sides of surfaces, no backs of them, little sky, and
// some light. The same view for the same scene and seed.
// throws   InputError when no place in air was found
Camera chooseView(const LightTransport& transport, double fov_y, double aspect, uint64_t seed);

// The same from one of these eyes, in the first of twelve directions around it that shows most.
// eyes_m   in air, at least one
Camera bestView(const LightTransport& transport, const std::vector<glm::dvec3>& eyes_m, double fov_y, double aspect);

}  // namespace nlg
