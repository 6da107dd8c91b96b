// Sky and sun that a user gives to a scene, and those that one without any light gets.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"
#include "tool/options.h"

namespace nlg {

struct LightOptions {
  std::vector<std::string> sky;  // nothing: the scene's own; r,g,b; or those of zenith, horizon and ground; or 0; or the path of
                                 // an image (sky_file.h), which degrees from +x towards +z and a factor may follow
  std::vector<std::string> sun;  // nothing: the scene's own; azimuth,elevation,r,g,b; or 0
};

void describe(LightOptions& options, OptionTable& table);

// Whether anything shines in the scene: sky, suns, lamps, emissive triangles, baked light.
bool hasLight(const Scene& scene);

// What a scene without any light gets: a clear sky by day. Radiances of about 1, for surfaces that a picture shows as they are.
Sky defaultSky();
Sun defaultSun();

// Replaces the scene's sky and suns by those of the options, where the sun of a sky's image joins the scene's own; then, where nothing at all shines and no option was given, adds
// defaultSky and defaultSun.
//
// returns   what it did, a line each; nothing when the scene stays as it is
// throws    UsageError on numbers that are none, negative or too many; InputError as readSkyFile does
std::vector<std::string> applyLight(Scene& scene, const LightOptions& options);

}  // namespace nlg
