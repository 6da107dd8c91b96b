// Loads a scene by the text with which users, configurations and shards name it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/gltf/gltf_reader.h"
#include "scene/image/image_loader.h"
#include "scene/model/scene.h"
#include "scene/solid/transmissive.h"
#include "tool/command/options.h"

namespace nlg {

struct SceneSource {
  std::string family = "level";  // procedural family, name of a built-in scene, or "level"
  std::string id;                // "house_3"; the file's stem, or its whole name where that is one such; a map's in lower case
  std::string sha256;            // of the scene as it was read: sceneSha256; empty for a procedural one
  Scene scene;
  std::vector<std::string> light_notes;  // what its light lost in reading (bsp_reader.h), or was given (light_options.h)
  double unit_m = 0.0;                   // metres of one of the file's units, as it was read; 0: its format has a unit of its own
  std::string unit_question;             // where nobody named a unit, and the size of a large scene leaves it open: scene_size.h
  std::vector<std::string> notes;        // whatever else its user should know: obj_reader.h, scene_size.h
  std::vector<std::string> counts;       // what its reader left out or replaced as a matter of course, for who asks
};

// A room may be no wider than four cavities: else a small scene, or one in the wrong unit, would be nothing but a cavity.
inline constexpr double kCavityShare = 0.25;

// How a scene is read from its file.
struct SceneReading {
  // Metres of one unit of a glTF or .obj file. 0: the metre, as is glTF's rule, unless its size leaves no doubt of another.
  double unit_m = 0.0;
  double transmissive_cover = kDenseTransmissive;  // dense_transmissive of judgeTransmissive
  double cavity_m = 0.5;              // Scene::cavity_m, of which a small scene takes less: kCavityShare of its shortest side
  GltfChoice gltf;                    // of a glTF file: which scene, and what of it
  ImageNeed images = ImageNeed::all;  // geometry: where no light is asked for
};

// Adds these to a tool's table, and to its --help what a scene may take (scene_file.h).
void describe(SceneReading& reading, OptionTable& table);

// request   FAMILY:SEED for a procedural scene (house:3), NAME or NAME:SEED for a built-in one (cornell, two_rooms:1);
//           PATH:PLAN:SEED for an interior (interiors/interiors.h), PATH a .sh3f file or a folder of them (Scopia.sh3f:flat:3);
//           PATH:MAP for a level in archives, PATH a .pk3 file or a folder of them (baseoa:kaos2 is maps/kaos2.bsp); otherwise
//           the path of a file of a SceneFormat
//           Where reading.unit_m is 0 and certainUnit knows one, it is read with that, and a note says so.
// throws    UsageError on a seed that is no decimal number, and on a unit of a scene that is no glTF or .obj file; InputError on
//           one whose longest side is under 10 cm or over 100 km; whatever the reader throws
SceneSource loadScene(const std::string& request, const SceneReading& reading = {});

// A format of files that each hold one scene.
struct SceneFormat {
  std::string_view ending;  // ".glb", in lower case
  SceneSource (*read)(const std::string& path, const SceneReading& reading);
  bool has_unit;  // false: a unit of its own, and reading.unit_m is refused
  bool is_gltf;   // false: a choice of glTF's scenes and nodes is refused
};
// null: none has this ending, in whatever case.
const SceneFormat* formatOf(const std::string& path);

// Whether a path ends as files (".fbx") of a format that nothing here reads, and an export away.
bool isOtherFormat(const std::string& path);

// What `request` may be, in one sentence for --help.
std::string sceneForms();

// Says on stderr what a tool's user should know of the scene, a line each.
void tellNotes(const std::string& tool, const SceneSource& source);
// The same of where its light comes from: "light: sky …".
void tellLightNotes(const SceneSource& source);

}  // namespace nlg
