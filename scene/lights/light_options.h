// Options of a scene's light: sky, sun, unit, intensity and groups; and the default light of a dark scene.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scene/model/scene.h"
#include "tool/command/options.h"

namespace nlg {

struct LightOptions {
  std::vector<std::string> sky;  // nothing: the scene's own; r,g,b; or those of zenith, horizon and ground; or 0; or the path of
                                 // an image (sky_file.h), which degrees from +x towards +z and a factor may follow
  std::vector<std::string> sun;  // nothing: the scene's own; azimuth,elevation,r,g,b; or 0
  std::string light_unit = "auto";   // of the scene's own lamps and suns: auto, file, watt, pi
  double intensity = 1.0;            // of all light
  std::string light_groups = "one";  // into which it falls (light_groups.h)
  std::string light_state;           // "day": of which this is all light; empty: the level has one
};

void describe(LightOptions& options, OptionTable& table);

// Whether anything shines in the scene: sky, suns, lamps, emissive triangles, baked light.
bool hasLight(const Scene& scene);

// Whether lamps and suns are known to be in another unit than emission: LightUnit.
bool isInOtherUnit(const Scene& scene);
// What is said where nobody knows; else nothing.
std::string unsureUnit(const Scene& scene);

// What a scene without any light gets: a clear sky by day. Radiances of about 1, for surfaces that a picture shows as they are.
Sky defaultSky();
Sun defaultSun();

// Gives a scene the light that the options ask for, in this order.
// 1. Lamps and suns are brought into emission's unit as light_unit says; "auto" does so by LightUnit, unless neither emission nor what
//    follows shines beside them.
// 2. The options' sky and suns replace the scene's own. The sun of a sky's image joins the scene's.
// 3. Without either option a scene in which nothing shines gets defaultSky and defaultSun, and so does an open one without light from
//    outside.
// 4. All light is multiplied by intensity.
// 5. What shines falls into the groups of light_groups, which are named as of light_state.
//
// isOpen       says whether a scene lies under the open sky; asked only where it matters
// returns   what it did, a line each, and whether light is brighter than engines' files hold; nothing when the scene stays as it is
// throws    UsageError on numbers that are none, negative or too many, and on an unknown unit; as readSkyFile and groupLights do
std::vector<std::string> applyLight(Scene& scene, const LightOptions& options,
                                    const std::function<bool(const Scene&)>& isOpen = nullptr);

}  // namespace nlg
