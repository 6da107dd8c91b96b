#include "scene/scene_source.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scene/archive/pk3_archive.h"
#include "scene/archive/scene_file.h"
#include "scene/interiors/interiors.h"
#include "scene/model/surface_look.h"
#include "scene/obj/obj_reader.h"
#include "scene/procedural/procedural.h"
#include "scene/quake/bsp_reader.h"
#include "scene/scene_size.h"
#include "scene/solid/double_sided.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/printable.h"

namespace nlg {

namespace {

namespace fs = std::filesystem;

// Where PATH:MAP has its colon; npos when the request names a file.
size_t archiveColon(const std::string& request) {
  const size_t colon = request.rfind(':');
  std::error_code error;
  if (colon == std::string::npos || fs::is_regular_file(request, error)) return std::string::npos;
  const std::string path = request.substr(0, colon);
  noteInput(path);
  const bool is_archive = extensionOf(path) == ".pk3" || fs::is_directory(path, error);
  return is_archive ? colon : std::string::npos;
}

// Of what was read from files.
SceneSource sourceOf(Scene scene) {
  SceneSource source;
  source.id = scene.id;
  source.sha256 = sceneSha256(scene);
  source.scene = std::move(scene);
  return source;
}

SceneSource sourceOf(BspLevel level) {
  SceneSource source = sourceOf(std::move(level.scene));
  for (const auto& [reason, faces] : level.dropped_faces)
    source.counts.push_back(fmt::format("{} faces are no geometry: {}", faces, reason));
  if (level.materials_without_texture > 0)
    source.counts.push_back(fmt::format("{} materials without a texture: grey", level.materials_without_texture));
  source.notes = std::move(level.notes);
  source.light_notes = std::move(level.light_notes);
  return source;
}

// form   the request's, for the error
uint64_t seedOf(const std::string& number, const std::string& form) {
  if (number.empty() || number.size() > 18 || number.find_first_not_of("0123456789") != std::string::npos)
    throw UsageError("scene", form + " with a decimal seed", "'" + number + "'");
  return std::stoull(number);
}

// A request of PATH:PLAN:SEED for an interior.
struct InteriorRequest {
  std::string path, plan, seed;
};

// False when the request names something else: interiors are of .sh3f files, or of folders with a plan's name behind.
bool readInterior(const std::string& request, InteriorRequest* found) {
  const size_t last = request.rfind(':');
  const size_t first = last == std::string::npos || last == 0 ? std::string::npos : request.rfind(':', last - 1);
  if (first == std::string::npos) return false;
  *found = {request.substr(0, first), request.substr(first + 1, last - first - 1), request.substr(last + 1)};
  const std::vector<std::string>& plans = interiorPlans();
  const bool is_file = extensionOf(found->path) == ".sh3f";
  return is_file || std::find(plans.begin(), plans.end(), found->plan) != plans.end();
}

// The seed behind NAME:, or 0 for a built-in scene's name alone; false when the request names something else.
bool readSeed(const std::string& request, const std::string& name, bool may_stand_alone, uint64_t* seed) {
  *seed = 0;
  if (may_stand_alone && request == name) return true;
  if (request.rfind(name + ":", 0) != 0) return false;
  *seed = seedOf(request.substr(name.size() + 1), name + ":SEED");
  return true;
}

SceneSource sourceOf(const std::string& family, uint64_t seed, Scene scene) {
  SceneSource source;
  source.family = family;
  source.id = family + "_" + std::to_string(seed);
  source.scene = std::move(scene);
  return source;
}

SceneSource readInterior(const InteriorRequest& request) {
  Interior interior = makeInterior(request.path, request.plan, seedOf(request.seed, "PATH:PLAN:SEED"));
  SceneSource source = sourceOf(std::move(interior.scene));
  source.family = request.plan;
  for (const auto& [what, models] : interior.models) source.counts.push_back(fmt::format("{} models: {}", models, what));
  return source;
}

// Whether a procedural scene has such a name: house_3.
bool isProceduralName(const std::string& id) {
  const size_t seed = id.rfind('_') + 1;
  const std::vector<std::string>& families = proceduralFamilies();
  return seed > 1 && seed < id.size() && id.find_first_not_of("0123456789", seed) == std::string::npos &&
         std::find(families.begin(), families.end(), id.substr(0, seed - 1)) != families.end();
}

// Of materials whose light is less than their file says; empty without any.
std::string whiteNote(const Scene& scene) {
  std::set<uint32_t> white;
  for (const uint32_t m : scene.triangle_material) {
    const Material& material = scene.materials[m];
    const glm::vec3& base = material.base_color;
    if (!material.base_image.isThere() && std::max({base.r, base.g, base.b}) > kWhitestFactor + 1e-6f) white.insert(m);
  }
  if (white.empty()) return "";
  return fmt::format("{} brighter than {:g} of white: light takes {:g}", counted(white.size(), "material is", "materials are"),
                     kWhitestFactor, kWhitestFactor);
}

constexpr float kAskedFromM = 50.0f;  // across: a bake of an odd size from here on is not begun unasked

double metresOf(const SceneReading& reading) { return reading.unit_m > 0.0 ? reading.unit_m : 1.0; }

// Of a file that says nothing of its unit, or says it wrongly.
SceneSource sourceOf(Scene scene, std::vector<std::string> notes, const std::string& path, const SceneReading& reading) {
  SceneSource source = sourceOf(std::move(scene));
  source.unit_m = metresOf(reading);
  source.notes = std::move(notes);
  const std::string white = whiteNote(source.scene);
  if (!white.empty() && reading.images == ImageNeed::all) source.notes.push_back(white);
  const std::string size = sizeNote(source.scene, path, source.unit_m);
  if (!size.empty()) source.notes.push_back(size);
  // what is too small bakes in seconds, and may be a model of a room: the note will do
  const Bounds bounds = sceneBounds(source.scene);
  if (reading.unit_m == 0.0 && glm::length(bounds.max - bounds.min) > kAskedFromM) source.unit_question = size;
  return source;
}

// read   reads the file with the unit that it is given
template <class Read>
SceneSource readInUnit(const SceneReading& reading, const Read& read) {
  SceneSource source = read(reading);
  const double unit_m = source.unit_question.empty() ? 0.0 : certainUnit(source.scene);
  if (unit_m == 0.0) return source;
  SceneReading other = reading;
  other.unit_m = unit_m;
  source = read(other);
  const Bounds bounds = sceneBounds(source.scene);
  const glm::vec3 size = bounds.max - bounds.min;
  source.notes.push_back(
      fmt::format("read in {}: {:.3g} x {:.3g} x {:.3g} m; in metres its rooms would be higher than 200 m; --unit 1 keeps metres",
                  unit_m == 0.01 ? "centimetres" : "millimetres", size.x, size.y, size.z));
  return source;
}

SceneSource readObjFile(const std::string& path, const SceneReading& reading) {
  ObjLevel level = readObj(path, metresOf(reading), reading.transmissive_cover, reading.images);
  return sourceOf(std::move(level.scene), std::move(level.notes), path, reading);
}

// Of what was asked for, as much as a scene takes.
double cavityOf(const Scene& scene, double cavity_m) {
  const Bounds bounds = sceneBounds(scene);
  const glm::dvec3 most_m = kCavityShare * (glm::dvec3(bounds.max) - glm::dvec3(bounds.min));
  return std::min({cavity_m, most_m.x, most_m.y, most_m.z});
}

SceneSource readGltfFile(const std::string& path, const SceneReading& reading) {
  GltfLevel level = readGltf(path, metresOf(reading), reading.transmissive_cover, reading.gltf, reading.images);
  level.scene.cavity_m = cavityOf(level.scene, reading.cavity_m);  // which tells rooms from walls
  const std::string sides = giveSolidsOneSide(level.scene).note();
  if (!sides.empty()) level.notes.push_back(sides);
  return sourceOf(std::move(level.scene), std::move(level.notes), path, reading);
}

constexpr SceneFormat kFormats[] = {
    {".glb", readGltfFile, true, true},
    {".gltf", readGltfFile, true, true},
    {".obj", readObjFile, true, false},
    {".bsp", [](const std::string& path, const SceneReading&) { return sourceOf(readBsp(path)); }, false, false}};

// ".glb, .gltf, .obj or .bsp"
std::string endings() {
  std::string text;
  const size_t count = std::size(kFormats);
  for (size_t f = 0; f < count; ++f) text += std::string(f == 0 ? "" : f + 1 < count ? ", " : " or ").append(kFormats[f].ending);
  return text;
}

// What modellers may have instead: each is a way of an export away.
void refuseOtherFormats(const std::string& request) {
  if (!isOtherFormat(request)) return;
  const std::string extension = extensionOf(request);
  const char* const import = extension == ".blend" ? "open it in Blender" : "import it into Blender, or open it in what made it";
  throw InputError(
      request, "scene", "a " + endings() + " file",
      fmt::format("a {} file: {}, and export glTF (in Blender File > Export > glTF 2.0, with Include > Data > Punctual "
                  "Lights for its lamps)",
                  extension, import));
}

SceneSource readScene(const std::string& request, const SceneReading& reading) {
  refuseOtherFormats(request);
  const SceneFormat* const format = formatOf(request);
  const size_t colon = archiveColon(request);
  // an option that only the glTF reader knows is refused elsewhere, not ignored
  const bool is_other = (format != nullptr && !format->is_gltf) || colon != std::string::npos;
  if (is_other && !(reading.gltf.scene_name.empty() && reading.gltf.leave_out.empty()))
    throw UsageError(reading.gltf.scene_name.empty() ? "--leave-out" : "--scene-name", "a glTF file", request);
  if (format != nullptr && format->has_unit)
    return readInUnit(reading, [&](const SceneReading& r) { return format->read(request, r); });
  // procedural scenes are in metres, levels of games in a unit that their reader knows
  if (reading.unit_m != 0.0 && reading.unit_m != 1.0)
    throw UsageError("--unit", "1 for any scene but a glTF or .obj file", fmt::format("{:g} for {}", reading.unit_m, request));
  // names of generated scenes come before files of the same name
  uint64_t seed = 0;
  for (const std::string& family : proceduralFamilies()) {
    if (readSeed(request, family, false, &seed)) return sourceOf(family, seed, makeProceduralScene(family, seed));
  }
  for (const std::string& name : builtInScenes()) {
    if (readSeed(request, name, true, &seed)) return sourceOf(name, seed, makeBuiltInScene(name, seed));
  }
  InteriorRequest interior;
  if (readInterior(request, &interior)) return readInterior(interior);
  // ARCHIVES:LEVEL, a level within .pk3 files
  if (colon != std::string::npos)
    return sourceOf(
        readBspFromArchives(request.substr(0, colon), request.substr(colon + 1), reading.transmissive_cover, reading.images));
  if (format != nullptr) return format->read(request, reading);
  // what is no known form must be a file; the reader of glTF words all other problems of files
  std::error_code error;
  if (!fs::exists(request, error) && !error)
    throw InputError(request, "scene", sceneForms(), "a name that is none of these, and no file");
  return readGltfFile(request, reading);
}

}  // namespace

const SceneFormat* formatOf(const std::string& path) {
  const std::string extension = extensionOf(path);
  const auto* found = std::ranges::find(kFormats, extension, &SceneFormat::ending);
  return found == std::end(kFormats) ? nullptr : found;
}

bool isOtherFormat(const std::string& path) {
  static const std::set<std::string> kOthers = {".fbx", ".blend", ".usd", ".usda", ".usdc", ".usdz", ".dae", ".3ds", ".max",
                                                ".ma",  ".mb",    ".c4d", ".skp",  ".stl",  ".ply",  ".abc", ".x3d"};
  return kOthers.contains(extensionOf(path));
}

void describe(SceneReading& reading, OptionTable& table) {
  table.add(
      "unit", &reading.unit_m,
      "length of one unit of a glTF or .obj file, metres: 0.01 for centimetres, 0.0254 for inches. 0: metres, or centimetres or "
      "millimetres where the height of rooms leaves no doubt; a bake stops where the size leaves it open",
      0.0, 1e6);
  table.add("transmissive_cover", &reading.transmissive_cover,
            "share of light that a transmissive surface must stop to block weighting functions; below it the surface counts as "
            "air. 0: always blocks. Above 1: never blocks",
            0.0, 1.01);
  table.add("cavity_m", &reading.cavity_m,
            "width, metres, up to which a closed hollow, such as a box or a wall of two sheets, does not count as air; at most a "
            "quarter of the scene's shortest side. 0: all hollows count as air",
            0.0, 1e3);
  table.add("scene_name", &reading.gltf.scene_name,
            "scene of a glTF file, by its name or its number from 1. None: the file's default");
  table.addRepeated("leave_out", &reading.gltf.leave_out,
                    "names of glTF nodes that are not read, with all nodes below them; patterns with * and ?");
  table.addNote(sceneBudgets());
}

SceneSource loadScene(const std::string& request, const SceneReading& reading) {
  SceneSource source = readScene(request, reading);
  // data sets tell scenes by name
  if (!source.sha256.empty() && isProceduralName(source.id))
    source.id += archiveColon(request) == std::string::npos ? extensionOf(request) : ".bsp";
  source.scene.cavity_m = cavityOf(source.scene, reading.cavity_m);
  return source;
}

std::string sceneForms() {
  return fmt::format(
      "a {} file, FOLDER:MAP for a level in .pk3 archives, PATH.sh3f:PLAN:SEED for an interior, "
      "FAMILY:SEED for a procedural scene ({}), or a small scene for tests of light ({})",
      endings(), fmt::join(proceduralFamilies(), ", "), fmt::join(builtInScenes(), ", "));
}

void tellNotes(const std::string& tool, const SceneSource& source) {
  for (const std::string& note : source.notes) std::cerr << printable(tool + ": " + source.id + ": " + note) << '\n';
}

void tellLightNotes(const SceneSource& source) {
  for (const std::string& note : source.light_notes) std::cerr << "light: " << note << '\n';
}

}  // namespace nlg
