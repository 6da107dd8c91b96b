// Takes the noise of path tracing out of a picture that is to be looked at, not measured.
//
// An à-trous wavelet filter of irradiance, before albedo (Dammertz et al., HPG 2010), guided by planes, normals and what the noise of
// each pixel allows (Schied et al., HPG 2017): images on surfaces stay sharp, and so do edges of shadows that are no noise.
#pragma once

#include <vector>

#include "render/camera.h"
#include "render/rendered_scene.h"
#include "render/sight.h"

namespace nlg {

// light   by sample, with its deviation; samples without a receiver stay as they are
// sights  one sample a pixel, of the camera
std::vector<ReceivedLight> denoised(const Sights& sights, const Camera& camera, std::vector<ReceivedLight> light,
                                    int thread_count);

}  // namespace nlg
