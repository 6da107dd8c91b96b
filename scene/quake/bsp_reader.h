// Reads a level of a Quake III-family game: IBSP 46, by itself or inside .pk3 archives.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scene/image/image_loader.h"
#include "scene/model/scene.h"
#include "scene/solid/transmissive.h"

namespace nlg {

struct BspLevel {
  Scene scene;  // its id is the map's name
  // faces that are no geometry, by why: "sky", "nodraw", "fog", "liquid", "clip", "translucent", "flare"
  std::map<std::string, uint32_t> dropped_faces;
  uint32_t materials_without_texture = 0;  // have the default colour: no image of theirs is in the archives, or all are damaged
  std::vector<std::string> notes;          // what lets light through (transmissive.h)
  // what the level says of light and the scene does not hold, or holds otherwise; one line each
  std::vector<std::string> light_notes;
};

// The level's polygons, meshes (models that its compiler built in) and patches, these tessellated to within 4 cm; one unit is
// 0.0254 m; (x, y, z) of the file, z up, becomes (x, z, -y). Left out and counted: dropped_faces.
// The level itself is one SceneObject for each connected component ("worldspawn/7"), movable when it stands free
// (closed_shells.h); behind them stands a movable one for each submodel that has triangles, named by its entity ("func_door *3"),
// where that places it.
//
// Its light is that of docs/reference/quake3_light.md: baked light from lightmaps and vertices, faces of sky, lamps and
// suns that the entities hold, the light grid.
//
// path     a .bsp file; without archives, shader scripts and textures are not at hand: flags are those that the .bsp holds, all
//          faces are one-sided, all materials have the default colour, no face shines, the sky is dark
// throws   InputError naming file, place, expected and got on what parseBsp and readPlacements refuse, and on a level of more
//          triangles than its budget holds (scene_file.h), or of more than 256 MiB
BspLevel readBsp(const std::string& path);

// The same for maps/MAP.bsp in the archives at path (pk3_archive.h), with their shader scripts and textures: surface parameters
// add to the .bsp's flags, pages of light may lie in files (-external), cull none makes a material double_sided, its texture is its base_image; faces shine, and sky has its light
// and its suns. A script's first stage with alphaFunc GT0 or GE128 makes a transmissive surface of what its texture cuts out
// (transmissive.h), but for faces that are left out as "translucent".
//
// map      without regard to case
// dense_transmissive   as judgeTransmissive has it; need: of images
// throws   InputError also on what Pk3Archives and readShaderScripts refuse, and on a map that is not there (names some that are)
BspLevel readBspFromArchives(const std::string& path, const std::string& map, double dense_transmissive = kDenseTransmissive,
                             ImageNeed need = ImageNeed::all);

}  // namespace nlg
