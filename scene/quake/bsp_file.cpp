#include "scene/quake/bsp_file.h"

#include <bit>
#include <cmath>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint32_t kVersion = 46;
constexpr size_t kLumpCount = 17;
constexpr size_t kHeaderBytes = 8 + 8 * kLumpCount;
constexpr uint64_t kMaxFaceVertices = uint64_t{1} << 23;
constexpr uint64_t kMaxFaceIndices = uint64_t{3} << 23;
constexpr uint32_t kMaxPatchSide = 65;

struct Lump {
  const char* name;
  size_t number;
  size_t record_bytes;
  size_t max_count;  // ten times and more what any level has
};
constexpr Lump kEntities{"entities", 0, 1, size_t{1} << 24};
constexpr Lump kShaders{"shaders", 1, 72, size_t{1} << 16};
constexpr Lump kModels{"models", 7, 40, size_t{1} << 16};
constexpr Lump kVertices{"vertices", 10, 44, size_t{1} << 23};
constexpr Lump kIndices{"indices", 11, 4, size_t{3} << 23};
constexpr Lump kFaces{"faces", 13, 104, size_t{1} << 22};
constexpr Lump kLightmaps{"lightmaps", 14, 3 * kBspLightmapSide* kBspLightmapSide, size_t{1} << 10};

class BspParser {
 public:
  BspParser(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  BspFile parse() {
    if (bytes_.size() < kHeaderBytes) fail("header", std::to_string(kHeaderBytes) + " bytes", std::to_string(bytes_.size()));
    if (bytes_.substr(0, 4) != "IBSP") fail("header", "a level that begins with IBSP", "another file");
    if (word(4) != kVersion) fail("header", "version 46", std::to_string(word(4)));
    readShaders();
    readPositions();
    readIndices();
    readLightmaps();
    readFaces();
    readModels();
    file_.entities = std::string(records(kEntities).bytes);
    return std::move(file_);
  }

 private:
  struct Records {
    std::string_view bytes;
    size_t offset = 0;  // in the file
    size_t count = 0;
  };

  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got);
  }
  [[noreturn]] void fail(const Lump& lump, size_t record, const std::string& expected, const std::string& got) const {
    fail(std::string(lump.name) + " " + std::to_string(record), expected, got);
  }

  uint32_t word(size_t offset) const {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value |= static_cast<uint32_t>(static_cast<unsigned char>(bytes_[offset + i])) << (8 * i);
    return value;
  }

  float number(size_t offset) const { return std::bit_cast<float>(word(offset)); }
  uint8_t byte(size_t offset) const { return static_cast<uint8_t>(bytes_[offset]); }
  BspColour colour(size_t offset) const { return {byte(offset), byte(offset + 1), byte(offset + 2)}; }

  Records records(const Lump& lump) const {
    const uint64_t offset = word(8 + 8 * lump.number);
    const uint64_t size = word(12 + 8 * lump.number);
    const std::string place = std::string("lump ") + lump.name;
    if (offset > bytes_.size() || size > bytes_.size() - offset) {
      fail(place, "a range inside the file's " + std::to_string(bytes_.size()) + " bytes",
           std::to_string(size) + " bytes at " + std::to_string(offset));
    }
    if (size % lump.record_bytes != 0)
      fail(place, "records of " + std::to_string(lump.record_bytes) + " bytes", std::to_string(size) + " bytes");
    if (size / lump.record_bytes > lump.max_count)
      fail(place, "at most " + std::to_string(lump.max_count) + " records", std::to_string(size / lump.record_bytes));
    return {bytes_.substr(offset, size), offset, size / lump.record_bytes};
  }

  // A range of another lump's records.
  void checkRange(const Lump& lump, size_t record, const char* what, uint64_t first, uint64_t count, size_t limit) const {
    if (first <= limit && count <= limit - first) return;
    fail(lump, record, std::string(what) + " out of " + std::to_string(limit),
         std::to_string(count) + " from " + std::to_string(first) + " on");
  }

  void readShaders() {
    const Records shaders = records(kShaders);
    for (size_t i = 0; i < shaders.count; ++i) {
      const size_t at = shaders.offset + i * kShaders.record_bytes;
      const std::string_view name = bytes_.substr(at, 64);
      file_.shaders.push_back({std::string(name.substr(0, name.find('\0'))), word(at + 64), word(at + 68)});
    }
  }

  void readPositions() {
    const Records vertices = records(kVertices);
    file_.positions.reserve(vertices.count);
    file_.texture_places.reserve(vertices.count);
    file_.vertex_light.reserve(vertices.count);
    for (size_t i = 0; i < vertices.count; ++i) {
      const size_t at = vertices.offset + i * kVertices.record_bytes;
      glm::vec3 position;
      for (int axis = 0; axis < 3; ++axis) {
        position[axis] = number(at + 4 * axis);
        if (!(std::abs(position[axis]) <= kFarthestUnits))
          fail(kVertices, i, "coordinates within 1048576 units", std::to_string(position[axis]));
      }
      file_.positions.push_back(position);
      // no numbers, in some levels, where no texture is shown
      const glm::vec2 place(number(at + 12), number(at + 16));
      const bool is_place = std::abs(place.x) <= kFarthestUnits && std::abs(place.y) <= kFarthestUnits;
      file_.texture_places.push_back(is_place ? place : glm::vec2(0.0f));
      file_.vertex_light.push_back({{number(at + 20), number(at + 24)}, colour(at + 40)});
    }
  }

  void readLightmaps() {
    const Records lightmaps = records(kLightmaps);
    file_.lightmap_count = static_cast<uint32_t>(lightmaps.count);
    file_.lightmap_texels.reserve(lightmaps.bytes.size() / 3);
    for (size_t at = lightmaps.offset; at < lightmaps.offset + lightmaps.bytes.size(); at += 3)
      file_.lightmap_texels.push_back(colour(at));
  }

  void readIndices() {
    const Records indices = records(kIndices);
    file_.indices.reserve(indices.count);
    for (size_t i = 0; i < indices.count; ++i) file_.indices.push_back(word(indices.offset + 4 * i));
  }

  void readFaces() {
    const Records faces = records(kFaces);
    file_.faces.reserve(faces.count);
    uint64_t vertex_count = 0, index_count = 0;
    for (size_t i = 0; i < faces.count; ++i) {
      const size_t at = faces.offset + i * kFaces.record_bytes;
      const uint32_t kind = word(at + 8);
      if (kind < 1 || kind > 4) fail(kFaces, i, "a kind from 1 to 4", std::to_string(kind));
      BspFace face{word(at),
                   static_cast<BspFaceKind>(kind),
                   word(at + 12),
                   word(at + 16),
                   word(at + 20),
                   word(at + 24),
                   word(at + 96),
                   word(at + 100),
                   static_cast<int32_t>(word(at + 28))};
      checkRange(kFaces, i, "a shader", face.shader, 1, file_.shaders.size());
      if (face.kind != BspFaceKind::flare) checkFace(face, i);
      vertex_count += face.kind == BspFaceKind::flare ? 0 : face.vertex_count;
      index_count += face.kind == BspFaceKind::flare ? 0 : face.index_count;
      if (vertex_count > kMaxFaceVertices || index_count > kMaxFaceIndices)
        fail(kFaces, i, "at most 2^23 vertices and 3 * 2^23 indices in all", "more");
      file_.faces.push_back(face);
    }
  }

  void checkFace(const BspFace& face, size_t i) const {
    checkRange(kFaces, i, "vertices", face.first_vertex, face.vertex_count, file_.positions.size());
    checkRange(kFaces, i, "indices", face.first_index, face.index_count, file_.indices.size());
    if (face.lightmap >= 0 && static_cast<uint32_t>(face.lightmap) < file_.lightmap_count) checkLightmapPlaces(face);
    if (face.kind == BspFaceKind::patch) {
      for (const uint32_t side : {face.patch_width, face.patch_height}) {
        if (side < 3 || side > kMaxPatchSide || side % 2 == 0)
          fail(kFaces, i, "a patch with odd sides from 3 to 65", std::to_string(side));
      }
      const uint32_t count = face.patch_width * face.patch_height;
      if (count != face.vertex_count)
        fail(kFaces, i, "a patch of " + std::to_string(count) + " control points", std::to_string(face.vertex_count));
      return;
    }
    if (face.index_count % 3 != 0) fail(kFaces, i, "three indices a triangle", std::to_string(face.index_count) + " indices");
    for (uint32_t k = face.first_index; k < face.first_index + face.index_count; ++k) {
      if (file_.indices[k] >= face.vertex_count)
        fail(kFaces, i, "indices below " + std::to_string(face.vertex_count), std::to_string(file_.indices[k]));
    }
  }

  void checkLightmapPlaces(const BspFace& face) const {
    for (uint32_t k = face.first_vertex; k < face.first_vertex + face.vertex_count; ++k) {
      const glm::vec2& place = file_.vertex_light[k].lightmap_place;
      for (const float at : {place.x, place.y}) {
        if (!std::isfinite(at)) fail(kVertices, k, "finite lightmap coordinates", std::to_string(at));
      }
    }
  }

  void readModels() {
    const Records models = records(kModels);
    if (models.count == 0) fail("lump models", "at least one model", "none");
    uint64_t end = 0;
    for (size_t i = 0; i < models.count; ++i) {
      const size_t at = models.offset + i * kModels.record_bytes;
      BspModel model{word(at + 24), word(at + 28)};
      for (int axis = 0; axis < 3; ++axis) {
        model.min[axis] = number(at + 4 * axis);
        model.max[axis] = number(at + 12 + 4 * axis);
      }
      // only the light grid asks for bounds, and only for those of the level itself
      for (const glm::vec3& corner : {model.min, model.max}) {
        for (int axis = 0; axis < 3 && i == 0; ++axis) {
          if (!std::isfinite(corner[axis])) fail(kModels, i, "finite bounds", std::to_string(corner[axis]));
        }
      }
      checkRange(kModels, i, "faces", model.first_face, model.face_count, file_.faces.size());
      if (model.face_count > 0 && model.first_face < end)
        fail(kModels, i, "faces behind those of the models before it", "face " + std::to_string(model.first_face));
      if (model.face_count > 0) end = uint64_t{model.first_face} + model.face_count;
      file_.models.push_back(model);
    }
  }

  const std::string& path_;
  std::string_view bytes_;
  BspFile file_;
};

}  // namespace

BspFile parseBsp(const std::string& path, std::string_view bytes) { return BspParser(path, bytes).parse(); }

}  // namespace nlg
