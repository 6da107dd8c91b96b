// Converts light to colours: exposure and tone of pictures, and the colours of errors.
//
// A pixel shows its radiance times the exposure, through Khronos PBR Neutral (neutral_tone.glsl): up to .8 colours lose .04 of their light
// at most, above they approach 1 and white. Then sRGB's transfer.
#pragma once

#include "render/lit_picture.h"
#include "render/picture/image.h"

namespace nlg {

// The least irradiance that an eye adapts to: kLeastOfOpen of what the brightest source of the scene gives by itself. Of sky and suns that is
// on open ground, of lamps and what shines a metre before them. Darker places are shown dark. 0 in a scene where nothing shines.
inline constexpr double kLeastOfOpen = 1e-4;
double leastAdapted(const Scene& scene);

// The exposure that brings the median luminance, over pixels that have receivers and are not black, to middle grey before the curve: .18.
// 1 when all are black.
// least   irradiance: at most what shows a white surface with so much light as middle grey
double automaticExposure(const LitPicture& picture, double least = 0.0);
// One for pictures of one view side by side: of the first without noise, or of the first.
double panelExposure(const std::vector<const LitPicture*>& pictures, double least);

Image toneMapped(const LitPicture& picture, double exposure);

enum class ErrorKind {
  with_sign,  // of the luminance of irradiance: method less truth
  absolute,   // root mean square over the channels of irradiance
};

// Error by pixel in shares of truth's irradianceRms; pixels without receivers are grey, solid is hatched.
// range   > 0: the share whose colour is the map's last
Image errorMap(const LitPicture& picture, const LitPicture& truth, ErrorKind kind, double range);
// The same against a scale of one's own.
// full   the error of irradiance whose colour is the map's last; 0: nothing has a colour
Image errorMapUpTo(double full, const LitPicture& picture, const LitPicture& truth, ErrorKind kind);

// The smallest of … .1, .2, .5, 1, … that is at least value, which lies between 1e-6 and 1e6 or is taken as the nearer of both.
double nextScale(double value);

// The nextScale that few errors exceed: 5 in a hundred pixels.
double errorRange(const std::vector<const LitPicture*>& pictures, const LitPicture& truth);

}  // namespace nlg
