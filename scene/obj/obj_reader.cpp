#include "scene/obj/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "scene/archive/pk3_archive.h"
#include "scene/archive/scene_file.h"
#include "scene/model/vertex_colours.h"
#include "scene/obj/obj_text.h"
#include "scene/obj/polygon_cut.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr const char* kCorners = "vertices of the file, each three numbers within 1e9 m of the origin";

std::string_view textOf(const std::vector<unsigned char>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Opens the material libraries that a file names: those in its folder or below.
// bytes_left   must outlive what is returned
ObjLibrary librariesBeside(const std::string& path, SceneBudget& bytes_left) {
  return [path, &bytes_left](const std::string& name) {
    const FileBeside beside = findBeside(path, name);
    ObjLibraryFile file{beside.path, {}, {}, beside.problem, beside.guess};
    if (beside.path.empty()) return file;
    // by whatever name it goes
    file.key = std::filesystem::weakly_canonical(file.path).string();
    file.read = [&bytes_left, library = file.path] { return std::string(textOf(readSceneFile(library, "file", bytes_left))); };
    return file;
  };
}

// Reads the material libraries that lines name. Of two materials of one name the first counts.
class LibraryReader {
 public:
  LibraryReader(const ObjLibrary& library, UnreadWords* unread, std::vector<std::string>* notes)
      : library_(library), unread_(*unread), notes_(*notes) {}

  // One name or several: names may hold blanks, and then the longest that is there counts.
  void readLine(const std::string& line) {
    constexpr size_t kMostWords = 8;  // of a name
    const std::vector<std::string_view> words = wordsOf(line);
    for (size_t i = 1; i < words.size() && words[i][0] != '#';) {
      size_t end = std::min(words.size(), i + kMostWords);
      while (end > i && !read(namedBy(words[i], words[end - 1]))) --end;
      const bool is_there = end > i;
      // otherwise up to the first word that ends as a library does
      while (!is_there && end < words.size() && extensionOf(std::string(words[end++])) != ".mtl") continue;
      if (!is_there) note(namedBy(words[i], words[end - 1]), "");
      i = end;
    }
  }

  std::vector<MtlMaterial> materials;
  std::map<std::string, size_t> by_name;

 private:
  void note(const std::string& name, const std::string& guess) {
    notes_.push_back("mtllib \"" + name.substr(0, 80) + "\" " +
                     (guess.empty() ? library_(name).problem : "is read from " + guess));
  }

  // False where it is not there.
  bool read(const std::string& name) {
    const ObjLibraryFile file = library_(name);
    if (!file.problem.empty()) return false;
    // its materials are there already
    if (!opened_.insert(file.key).second) return true;
    if (!file.guess.empty()) note(name, file.guess);
    // images are named from where the library lies
    const std::filesystem::path folder = std::filesystem::path(name).parent_path();
    for (MtlMaterial& material : readMtlRecords(file.path, file.read(), &unread_)) {
      for (MtlImage* image : {&material.colour_image, &material.shine_image, &material.stops_image}) {
        const bool is_beside = !image->name.empty() && image->name[0] != '/' && image->name.find(':') == std::string::npos;
        if (is_beside) image->name = (folder / image->name).lexically_normal().string();
      }
      by_name.try_emplace(material.name, materials.size());
      materials.push_back(std::move(material));
    }
    return true;
  }

  const ObjLibrary& library_;
  UnreadWords& unread_;
  std::vector<std::string>& notes_;
  std::set<std::string> opened_;  // by key
};

class ObjConverter {
 public:
  ObjConverter(const std::string& path, double unit_m, const ObjFiles& files)
      : path_(path), unit_m_(unit_m), files_(files), loader_(files.need) {}

  ObjLevel convert(std::string_view text, double dense_transmissive) {
    load(text);
    convertMaterials();
    loadImages();
    for (size_t i = 0; i < file_.shapes.size(); ++i)
      addShape(file_.shapes[i].name, file_.shapes[i].first_face,
               i + 1 < file_.shapes.size() ? file_.shapes[i + 1].first_face : file_.faces.size());
    if (level_.scene.triangles.empty() && misplaced_count_ > 0)
      throw InputError(path_, "line " + std::to_string(first_misplaced_line_),
                       std::string("a face whose corners are ") + kCorners, "no such face in the whole file");
    noteLosses();
    level_.scene.id = std::filesystem::path(path_).stem().string();
    finishScene(level_.scene, world_positions_);
    std::vector<std::string> names;
    for (const MtlMaterial& source : materials_) names.push_back(source.name);
    for (std::string& note : judgeTransmissive(level_.scene, names, dense_transmissive)) level_.notes.push_back(std::move(note));
    return std::move(level_);
  }

 private:
  void load(std::string_view text) {
    file_ = readObjRecords(path_, text);
    LibraryReader libraries(files_.library, &file_.unread, &level_.notes);
    for (const std::string& line : file_.libraries) libraries.readLine(line);
    materials_ = std::move(libraries.materials);
    without_ = materials_.size();
    for (const std::string& name : file_.material_names) {
      const auto known = libraries.by_name.find(name);
      material_of_.push_back(known == libraries.by_name.end() ? without_ : known->second);
    }
    makeColours();
  }

  void makeColours() {
    std::vector<float> numbers;
    for (const glm::vec3& colour : file_.colours) numbers.insert(numbers.end(), {colour.r, colour.g, colour.b});
    const float white = whiteOf(numbers);
    const size_t cut_count = makeShares(white, &numbers);
    for (size_t i = 0; i < numbers.size(); ++i) file_.colours[i / 3][static_cast<int>(i % 3)] = numbers[i];
    if (white > 1.0f) level_.notes.push_back(fmt::format("colours of vertices: taken as of 0 to {:g}", white));
    if (cut_count > 0)
      level_.notes.push_back(fmt::format("colours of vertices: {} numbers outside of 0 to {:g} are cut", cut_count, white));
  }

  size_t materialOf(const ObjFace& face) const {
    return face.material < 0 ? without_ : material_of_[static_cast<size_t>(face.material)];
  }

  void convertMaterials() {
    std::set<size_t> used;
    for (const ObjFace& face : file_.faces) used.insert(materialOf(face));
    used.erase(without_);
    const std::vector<double> stops = stoppedShares(used);
    for (size_t i = 0; i < materials_.size(); ++i) {
      const MtlMaterial& source = materials_[i];
      Material material;
      material.label.name = source.name;
      // what has an image alone is its image; what has neither is grey
      const bool has_image = !source.colour_image.name.empty();
      // by the letter black; but programs write it beside images, and show them
      const bool is_black = has_image && source.colour == glm::dvec3(0.0);
      const glm::dvec3 colour = is_black ? glm::dvec3(1.0) : source.colour.value_or(glm::dvec3(has_image ? 1.0 : kUnreadGrey));
      material.base_color = glm::vec3(glm::min(colour, glm::dvec3(1.0)));
      material.emissive = glm::vec3(source.shine.value_or(glm::dvec3(source.shine_image.name.empty() ? 0.0 : 1.0)));
      clamped_count_ += colour != glm::min(colour, glm::dvec3(1.0)) ? 1 : 0;
      const bool is_used = used.count(i) > 0;
      if (is_used && is_black) black_.push_back(i);
      colourless_count_ += is_used && !source.colour && !has_image ? 1 : 0;
      if (stops[i] < 1.0) material.transmissive = Transmissive::thin;  // what it is in truth is judged once the scene is there
      material.opacity = static_cast<float>(stops[i]);
      if (is_used) wantImages(source, &material);
      level_.scene.materials.push_back(material);
    }
    level_.scene.materials.emplace_back();
    materials_.emplace_back();
  }

  // Of d and Tr, which programs write by either meaning: where by one of them no material would stop all light, it is the other.
  std::vector<double> stoppedShares(const std::set<size_t>& used) {
    std::vector<double> shares;
    for (const MtlMaterial& m : materials_) {
      shares.push_back(m.stops.value_or(1.0 - m.passes.value_or(0.0)));
      contradicting_count_ += m.stops && m.passes && std::abs(*m.stops + *m.passes - 1.0) > 0.01 ? 1 : 0;
    }
    const auto isWhole = [&](size_t i) { return shares[i] >= 1.0; };
    const auto isClear = [&](size_t i) { return shares[i] == 0.0; };
    const auto isClearByTr = [&](size_t i) { return isClear(i) && !materials_[i].stops; };
    if (used.empty() || std::any_of(used.begin(), used.end(), isWhole)) return shares;
    if (std::any_of(used.begin(), used.end(), isClearByTr)) {
      for (size_t i = 0; i < shares.size(); ++i) shares[i] = materials_[i].stops ? shares[i] : materials_[i].passes.value_or(1.0);
      level_.notes.push_back("Tr is taken for what is stopped: by its other meaning no material would stop all light");
    }
    if (std::all_of(used.begin(), used.end(), isClear)) {
      shares.assign(shares.size(), 1.0);
      level_.notes.push_back("by d no material would stop any light: all are taken to stop all of it");
    }
    return shares;
  }

  void wantImages(const MtlMaterial& source, Material* material) {
    const std::string &colour = source.colour_image.name, &opacity = source.stops_image.name;
    KeptAs kept;
    if (!opacity.empty()) {
      material->transmissive = Transmissive::thin;
      if (opacity == colour || colour.empty()) kept.opacity = KeptAs::Opacity::brightness;
      if (opacity != colour && !colour.empty()) kept.opacity_of = opacity;
      if (colour.empty()) kept.colour = KeptAs::Colour::white;
    }
    const auto want = [&](const MtlImage& image, const KeptAs& as, TextureUse* use) {
      if (image.name.empty()) return;
      use->image = loader_.want(image.name, as);
      if (image.clamp) use->wrap_u = use->wrap_v = TextureWrap::clamp;
    };
    want(baseImageOf(source), kept, &material->base_image);
    if (material->emissive != glm::vec3(0.0f))
      want(source.shine_image, {}, &material->emissive_image);
    else if (!source.shine_image.name.empty())
      ++dark_count_;
  }

  static const MtlImage& baseImageOf(const MtlMaterial& source) {
    return source.colour_image.name.empty() ? source.stops_image : source.colour_image;
  }

  void loadImages() {
    if (loader_.wantsNone()) return;
    LoadedImages loaded = loader_.load(files_.image, *files_.pixels, path_);
    for (Material& material : level_.scene.materials) {
      if (!loaded.take(&material.base_image)) material.base_color *= kUnreadGrey;
      if (!loaded.take(&material.emissive_image)) material.emissive = glm::vec3(0.0f);
      has_base_places_ |= material.base_image.isThere();
      has_emissive_places_ |= material.emissive_image.isThere();
    }
    level_.scene.images = std::move(loaded.images);
    for (std::string& note : unreadImageNotes(loaded)) level_.notes.push_back(std::move(note));
  }

  void addShape(const std::string& shape_name, size_t first_face, size_t end_face) {
    Scene& scene = level_.scene;
    if (first_face == end_face) return;
    const std::string name = shape_name.empty() ? "object " + std::to_string(scene.objects.size()) : shape_name;
    const auto first_triangle = static_cast<uint32_t>(scene.triangles.size());
    VertexMap vertices;
    std::vector<glm::dvec3> outline;
    for (size_t f = first_face; f < end_face; ++f) {
      const ObjFace& face = file_.faces[f];
      const ObjCorner* const corners = &file_.corners[face.first_corner];
      outline.clear();
      for (uint32_t k = 0; k < face.corner_count; ++k)
        outline.push_back(corners[k].vertex < file_.positions.size() ? file_.positions[corners[k].vertex] : glm::dvec3(NAN));
      if (!std::all_of(outline.begin(), outline.end(), [&](const glm::dvec3& at) { return isPlaced(at); })) {
        if (++misplaced_count_ == 1) first_misplaced_line_ = face.line;
        continue;
      }
      const PolygonCut cut = cutPolygon(outline);
      if (!cut.holds_area && ++crossed_count_ == 1) first_crossed_line_ = face.line;
      const size_t material_idx = materialOf(face);
      for (const glm::uvec3& t : cut.triangles) {
        glm::uvec3 triangle;
        for (int k = 0; k < 3; ++k) triangle[k] = vertexOf(corners[t[k]], material_idx, &vertices);
        scene.triangles.push_back(triangle);
        scene.triangle_material.push_back(static_cast<uint32_t>(material_idx));
        faces_without_material_ += material_idx == without_ ? 1 : 0;
      }
    }
    const auto count = static_cast<uint32_t>(scene.triangles.size()) - first_triangle;
    if (count > 0) scene.objects.push_back({name, first_triangle, count, true});
  }

  // What makes a vertex of the scene: one of the file, and where its look is the material's, too, its place and material.
  struct VertexKey {
    uint32_t vertex;
    int32_t place;
    size_t material;
    bool operator==(const VertexKey&) const = default;
  };
  struct KeyHash {
    size_t operator()(const VertexKey& key) const {
      return static_cast<size_t>(key.vertex) + static_cast<size_t>(key.place) * 0x9e3779b97f4a7c15u +
             key.material * 0xc2b2ae3d27d4eb4fu;
    }
  };
  using VertexMap = std::unordered_map<VertexKey, uint32_t, KeyHash>;  // of one shape

  bool isPlaced(const glm::dvec3& at) const {
    const glm::dvec3 size = glm::abs(unit_m_ * at);
    return size.x <= kFarthestM && size.y <= kFarthestM && size.z <= kFarthestM;
  }

  uint32_t vertexOf(const ObjCorner& corner, size_t material_idx, VertexMap* vertices) {
    Scene& scene = level_.scene;
    const Material& material = scene.materials[material_idx];
    const MtlMaterial& source = materials_[material_idx];
    // by what the file names: a scene's vertices stay what they are whether its images are read or not
    const bool has_image = !baseImageOf(source).name.empty() || !source.shine_image.name.empty();
    const bool is_own = has_image || (!file_.colours.empty() && material_idx == without_);
    const VertexKey key{corner.vertex, has_image ? corner.place : -1, is_own ? material_idx : 0};
    const auto [entry, is_new] = vertices->emplace(key, static_cast<uint32_t>(world_positions_.size()));
    if (!is_new) return entry->second;
    world_positions_.push_back(unit_m_ * file_.positions[corner.vertex]);
    if (has_base_places_)
      scene.base_places.push_back(material.base_image.isThere() ? placeOf(corner, baseImageOf(source)) : glm::vec2(0.0f));
    if (has_emissive_places_)
      scene.emissive_places.push_back(material.emissive_image.isThere() ? placeOf(corner, source.shine_image) : glm::vec2(0.0f));
    if (!file_.colours.empty()) scene.vertex_colours.emplace_back(colourOf(corner.vertex, material_idx), 1.0f);
    return entry->second;
  }

  // Times the material's, which is grey where there is none: a vertex that has a colour needs none.
  glm::vec3 colourOf(uint32_t vertex, size_t material_idx) const {
    const glm::vec3& colour = file_.colours[vertex];
    if (std::isnan(colour.r)) return glm::vec3(1.0f);
    const bool is_without = material_idx == without_;
    return is_without ? colour / level_.scene.materials[material_idx].base_color : colour;
  }

  // v points up in the file, and down in the scene.
  glm::vec2 placeOf(const ObjCorner& corner, const MtlImage& image) {
    const bool is_there = corner.place >= 0 && static_cast<size_t>(corner.place) < file_.places.size();
    const glm::dvec2 place =
        is_there ? file_.places[static_cast<size_t>(corner.place)] * image.scale + image.offset : glm::dvec2(NAN);
    if (!std::isfinite(place.x) || !std::isfinite(place.y)) {
      ++unplaced_count_;
      return glm::vec2(0.0f);
    }
    return glm::vec2(glm::clamp(glm::dvec2(place.x, 1.0 - place.y), glm::dvec2(-1e9), glm::dvec2(1e9)));
  }

  void noteLosses() {
    const auto shows = [&](size_t i) { return level_.scene.materials[i].base_image.isThere(); };
    const auto black_count = static_cast<uint64_t>(std::count_if(black_.begin(), black_.end(), shows));
    const std::pair<uint64_t, std::string> losses[] = {
        {faces_without_material_, file_.colours.empty()
                                      ? "triangles without a material that was found: grey"
                                      : "triangles without a material that was found: grey, or their vertices' colours"},
        {file_.faces_of_two_corners, "faces of fewer than three corners: left out"},
        {crossed_count_, "faces whose outlines cross themselves are cut as well as can be, the first in line " +
                             std::to_string(first_crossed_line_)},
        {misplaced_count_, "faces whose corners are not all " + std::string(kCorners) + ": left out, the first in line " +
                               std::to_string(first_misplaced_line_)},
        {unplaced_count_, "vertices without a place on their image (vt): its corner instead"},
        {clamped_count_, "materials with a Kd above 1: cut to 1"},
        {black_count, "materials with a Kd of 0 beside map_Kd: their image shows"},
        {colourless_count_, "materials without Kd and map_Kd: grey"},
        {dark_count_, "materials with a map_Ke and a Ke of 0: dark"},
        {contradicting_count_, "materials whose d and Tr contradict each other: by d"}};
    for (const auto& [count, words] : losses) {
      if (count > 0) level_.notes.push_back(std::to_string(count) + " " + words);
    }
    std::string unread;
    for (const auto& [word, count] : file_.unread)
      unread += (unread.empty() ? "" : ", ") + word + " (" + std::to_string(count) + ")";
    if (!unread.empty()) level_.notes.push_back("words that are not read: " + unread);
  }

  const std::string path_;
  const double unit_m_;
  const ObjFiles& files_;
  ImageLoader loader_;
  bool has_base_places_ = false, has_emissive_places_ = false;
  ObjRecords file_;
  std::vector<MtlMaterial> materials_;  // in the end one more, of faces without: number without_
  size_t without_ = 0;
  std::vector<size_t> material_of_;  // by name of the file
  std::vector<glm::dvec3> world_positions_;
  uint64_t faces_without_material_ = 0, clamped_count_ = 0, unplaced_count_ = 0, colourless_count_ = 0, contradicting_count_ = 0,
           dark_count_ = 0;
  std::vector<size_t> black_;  // materials by whose factor their image would be black
  uint64_t crossed_count_ = 0, first_crossed_line_ = 0, misplaced_count_ = 0, first_misplaced_line_ = 0;
  ObjLevel level_;
};

}  // namespace

ObjLevel readObj(const std::string& path, double unit_m, double dense_transmissive, ImageNeed need) {
  SceneBudgets budgets;
  const std::vector<unsigned char> bytes = readSceneFile(path, "file", budgets.bytes);
  const auto image = [&](const std::string& name) { return imageBeside(path, name, budgets.bytes); };
  return readObjText(path, textOf(bytes), unit_m, {librariesBeside(path, budgets.bytes), image, &budgets.pixels, need},
                     dense_transmissive);
}

ObjLevel readObjText(const std::string& path, std::string_view text, double unit_m, const ObjFiles& files,
                     double dense_transmissive) {
  return ObjConverter(path, unit_m, files).convert(text, dense_transmissive);
}

}  // namespace nlg
