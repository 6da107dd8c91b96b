// Light groups, which an engine dims, colours and switches.
#pragma once

#include <string>

#include "scene/model/scene.h"

namespace nlg {

// Sorts all that shines into scene->light.groups, which it makes anew: sky first, then suns, lamps, emission, a level's own light.
//
// how      one: all light is one group; kind: "sky", "sun", "lamps", "emission", "level"; name: as kind, but suns, lamps and
//          materials that shine by their names, up to a number behind a last dot (Blender's Lamp.001). A group that the file's author
//          gives a light comes before either
// state    of light, such as "night": of all light that is one group the name, and of groups what comes before theirs: night/sky. Empty:
//          none
// throws   UsageError on another word, and on a state with ',', '/' or what is not seen; InputError on more than kMaxLightGroups groups
void groupLights(const std::string& how, const std::string& state, Scene* scene);

// Whether a group is of a state.
bool isOfState(const std::string& group, const std::string& state);

}  // namespace nlg
