// Reads skies from files: equirectangular images of radiance, .hdr and OpenEXR's .exr.
#pragma once

#include <string>

#include "scene/model/sky_image.h"

namespace nlg {

inline constexpr int kMaxSkyFileColumns = 32768;

struct SkyFile {
  SkyImage image;
  size_t mended = 0;  // numbers of the file that are no radiance (negative, above 1e12, NaN), taken as 0
};

// Whether a name ends as the files below do, in whatever case.
bool isSkyFile(const std::string& path);

// Read a few rows at a time, whatever the file's size.
//
// .hdr     RGBE, plain or run-length encoded, rows from the top; EXPOSURE is left aside, as nearly all programs do
// .exr     channels R, G and B, or Y alone, of a file of one part; all compressions; half, float or integers
// turn     in whole turns: by how much the image is turned from +x towards +z
// throws   InputError on a file that is none of these, with more channels than 1 MiB holds of a row, cut short, wider than kMaxSkyFileColumns, or not twice as wide as high
SkyFile readSkyFile(const std::string& path, double turn);

}  // namespace nlg
