// Takes the noise of path tracing out of a picture that is to be looked at, not measured.
//
// An à-trous wavelet filter of irradiance, before albedo (Dammertz et al., HPG 2010), guided by planes, normals and what the noise of
// each pixel allows (Schied et al., HPG 2017): images on surfaces stay sharp, and so do edges of shadows that are no noise.
#pragma once

#include <vector>

#include "light/methods/light_method.h"
#include "render/camera.h"
#include "render/sight.h"

namespace nlg {

// light   by sample, with its deviation; samples without a receiver stay as they are
// sights  one sample a pixel, of the camera
std::vector<LightAnswer> denoised(const Sights& sights, const Camera& camera, std::vector<LightAnswer> light, int thread_count);

}  // namespace nlg
