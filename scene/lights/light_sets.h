// Light groups, which an engine dims, colours and switches, and light sets: several states of a level's light, such as day and night, in one grid, which an engine mixes.
//
// A light set's light is one group of the grid's, of the set's name; or, where its own lights fall into groups (light_sets.h), as many,
// each named SET/GROUP. A grid begins with the first set.
#pragma once

#include <string>
#include <vector>

#include "scene/lights/light_options.h"
#include "scene/model/scene.h"
#include "scene/scene_source.h"

namespace nlg {

// Sorts all that shines into scene->light.groups, which it makes anew: sky first, then suns, lamps, emission, a level's own light.
//
// how      one: all light is one group; kind: "sky", "sun", "lamps", "emission", "level"; name: as kind, but suns, lamps and
//          materials that shine by their names, up to a number behind a last dot (Blender's Lamp.001). A group that the file's author
//          gives a light comes before either
// throws   UsageError on another word; InputError on more than kMaxLightGroups groups
void groupLights(const std::string& how, Scene* scene);

struct LightSet {
  std::string name;
  std::string scene;     // of the same geometry: whose lamps, sky, suns and materials these are; empty: the level itself
  LightOptions options;  // of this set
};

// texts    NAME[=SCENE][ OPTION=VALUE]…, each a set: "day", "night=level_night.glb sky=0 sun=0 light_groups=name". Options are those of
//          LightOptions, each at most once; a name has no blanks, ',' and '/'
// of_all   what sets take that say nothing else
// throws   UsageError
std::vector<LightSet> lightSetsFrom(const std::vector<std::string>& texts, const LightOptions& of_all);

// What may be files, and is read of a level beside its own: scenes of sets, and images of skies.
std::vector<std::string> filesOfLight(const std::vector<std::string>& texts, const LightOptions& of_all);

// The scene as it is lit by each of its sets, of which there may be none: then by all its light. It must outlive them.
std::vector<const Scene*> litScenes(const SceneSource& source);

// The groups of light that a grid of it keeps apart, in their order; none where all light is one.
std::vector<std::string> lightGroupNames(const SceneSource& source);
// How many of them the first set has: all without sets.
size_t firstGroupCount(const SceneSource& source);

// sceneLightSha256 of a scene; with sets a hash of their names and of each one's.
std::string lightSha256(const SceneSource& source);
// The same whatever groups the lights of a scene, or of a set, are in.
std::string ungroupedLightSha256(const SceneSource& source);

}  // namespace nlg
