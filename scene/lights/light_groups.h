// Groups a scene's lights into those that an engine can dim, colour and switch.
#pragma once

#include <string>

#include "scene/scene.h"

namespace nlg {

// Sorts all that shines into scene->light.groups, which it makes anew: sky first, then suns, lamps, emission, a level's own light.
//
// how      one: all light is one group; kind: "sky", "sun", "lamps", "emission", "level"; name: as kind, but suns, lamps and
//          materials that shine by their names, up to a number behind a last dot (Blender's Lamp.001). A group that the file's author
//          gives a light comes before either
// throws   UsageError on another word; InputError on more than kMaxLightGroups groups
void groupLights(const std::string& how, Scene* scene);

}  // namespace nlg
