#include "scene/gltf_json.h"

#include <algorithm>
#include <array>
#include <set>

#include <nlohmann/json.hpp>

#include "tool/error.h"

namespace nlg {
namespace {

using Json = nlohmann::json;

constexpr int kDeepest = 64;
constexpr const char *kMeshopt = "EXT_meshopt_compression", *kDraco = "KHR_draco_mesh_compression";

// What a property is. index: below 2^31, as tinygltf keeps it; integer: below 2^53; the last three are arrays.
enum class Kind { boolean, index, integer, number, string, object, numbers, indices, objects };

const char* kindName(Kind kind) {
  constexpr std::array<const char*, 9> kNames = {"boolean", "index", "integer", "number", "string",
                                                 "object",  "array", "array",   "array"};
  return kNames[static_cast<size_t>(kind)];
}

// What a property must be when it is there: those that the reader depends on.
struct Rule {
  std::string_view section, key;
  Kind kind;
  size_t length = 0;  // of numbers: how many, since tinygltf ignores those of another length; 0: any
};

constexpr Rule kRules[] = {{"buffers", "uri", Kind::string},
                           {"buffers", "byteLength", Kind::integer},
                           {"buffers", "fallback", Kind::boolean},
                           {"bufferViews", "buffer", Kind::index},
                           {"bufferViews", "byteOffset", Kind::integer},
                           {"bufferViews", "byteLength", Kind::integer},
                           {"bufferViews", "byteStride", Kind::index},
                           {"bufferViews", "count", Kind::index},
                           {"bufferViews", "mode", Kind::string},
                           {"bufferViews", "filter", Kind::string},
                           {"accessors", "bufferView", Kind::index},
                           {"accessors", "byteOffset", Kind::integer},
                           {"accessors", "componentType", Kind::index},
                           {"accessors", "count", Kind::integer},
                           {"accessors", "normalized", Kind::boolean},
                           {"accessors", "sparse", Kind::object},
                           {"meshes", "bufferView", Kind::index},
                           {"meshes", "primitives", Kind::objects},
                           {"meshes", "attributes", Kind::object},
                           {"meshes", "POSITION", Kind::index},
                           {"meshes", "indices", Kind::index},
                           {"meshes", "material", Kind::index},
                           {"meshes", "mode", Kind::index},
                           {"nodes", "mesh", Kind::index},
                           {"nodes", "children", Kind::indices},
                           {"nodes", "translation", Kind::numbers, 3},
                           {"nodes", "rotation", Kind::numbers, 4},
                           {"nodes", "scale", Kind::numbers, 3},
                           {"nodes", "matrix", Kind::numbers, 16},
                           {"scenes", "nodes", Kind::indices},
                           {"materials", "pbrMetallicRoughness", Kind::object},
                           {"materials", "baseColorFactor", Kind::numbers, 4},
                           {"materials", "emissiveFactor", Kind::numbers, 3},
                           {"materials", "doubleSided", Kind::boolean},
                           {"materials", "alphaMode", Kind::string},
                           {"materials", "alphaCutoff", Kind::number},
                           {"materials", "baseColorTexture", Kind::object},
                           {"materials", "emissiveTexture", Kind::object},
                           {"materials", "index", Kind::index},
                           {"materials", "texCoord", Kind::index},
                           {"materials", "transmissionFactor", Kind::number},
                           {"materials", "emissiveStrength", Kind::number},
                           {"textures", "source", Kind::index},
                           {"textures", "sampler", Kind::index},
                           {"samplers", "wrapS", Kind::index},
                           {"samplers", "wrapT", Kind::index},
                           {"images", "uri", Kind::string},
                           {"images", "bufferView", Kind::index}};

constexpr const char* kSections[] = {"buffers", "bufferViews", "accessors", "meshes",   "nodes",
                                     "scenes",  "materials",   "textures",  "samplers", "images"};

// Extensions whose members the rules hold for, too; whatever else stands in an extension is anybody's.
constexpr std::string_view kCheckedExtensions[] = {
    "KHR_materials_emissive_strength", "KHR_materials_transmission", "EXT_texture_webp", "KHR_texture_basisu", kDraco, kMeshopt};

// Extensions that a file may require: those that the reader follows, and, by the beginnings of their names, those about looks, which
// can be missing. Any other may change where triangles are.
constexpr std::string_view kReadExtensions[] = {"KHR_mesh_quantization", kMeshopt, kDraco};
constexpr std::string_view kLookExtensions[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"};

bool isOf(Kind kind, const Json& value) {
  switch (kind) {
    case Kind::boolean:
      return value.is_boolean();
    case Kind::index:
      return value.is_number_unsigned() && value.get<uint64_t>() < uint64_t{1} << 31;
    case Kind::integer:
      return value.is_number_unsigned() && value.get<uint64_t>() < uint64_t{1} << 53;
    case Kind::number:
      return value.is_number();
    case Kind::string:
      return value.is_string();
    case Kind::object:
      return value.is_object();
    default:
      return value.is_array();
  }
}

// An extension of an object's; null where it has none.
const Json* extensionOf(const Json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end() || !extensions->is_object()) return nullptr;
  const auto extension = extensions->find(name);
  return extension == extensions->end() ? nullptr : &*extension;
}

// Its bytes are nowhere: views into it are unpacked from elsewhere.
bool isFallback(const Json& buffer) {
  const Json* extension = extensionOf(buffer, kMeshopt);
  return extension != nullptr && extension->is_object() && extension->value("fallback", false);
}

class JsonChecker {
 public:
  JsonChecker(const std::string& path, const Json& root, bool is_binary) : path_(path), root_(root), is_binary_(is_binary) {}

  std::vector<std::string> check() {
    require(Kind::object, root_, "root");
    // of glTF 1.0 nothing else fits
    if (root_.contains("asset") && root_["asset"].is_object() && root_["asset"].contains("version")) {
      const Json& version = root_["asset"]["version"];
      if (version.is_string() && !version.get<std::string>().starts_with("2"))
        fail("asset.version", "2.0", version.get<std::string>());
    }
    checkRequiredExtensions();
    if (root_.contains("scene")) require(Kind::index, root_["scene"], "scene");
    for (const char* section : kSections) {
      if (!root_.contains(section)) continue;
      require(Kind::objects, root_[section], section);
      checkElements(section, root_[section], section, false);
    }
    for (size_t i = 0; root_.contains("buffers") && i < root_["buffers"].size(); ++i)
      checkBuffer(root_["buffers"][i], i, "buffers[" + std::to_string(i) + "]");
    for (size_t i = 0; root_.contains("nodes") && i < root_["nodes"].size(); ++i) {
      const Json& node = root_["nodes"][i];
      const bool is_moved = node.contains("translation") || node.contains("rotation") || node.contains("scale");
      if (node.contains("matrix") && is_moved)
        fail("nodes[" + std::to_string(i) + "]", "a matrix or translation, rotation and scale", "both");
    }
    return std::move(buffer_files_);
  }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got.substr(0, 80));
  }

  void require(Kind kind, const Json& value, const std::string& place) const {
    if (!isOf(kind, value))
      fail(place, std::string("a JSON ") + kindName(kind), value.is_structured() ? value.type_name() : value.dump());
    for (size_t i = 0; (kind == Kind::indices || kind == Kind::numbers || kind == Kind::objects) && i < value.size(); ++i) {
      const Kind element = kind == Kind::indices ? Kind::index : kind == Kind::objects ? Kind::object : Kind::number;
      if (!isOf(element, value[i])) require(element, value[i], place + "[" + std::to_string(i) + "]");
    }
  }

  // Before whatever else a file lacks: that may be what the extension provides for.
  void checkRequiredExtensions() const {
    const Json names = root_.value("extensionsRequired", Json::array());
    for (size_t i = 0; names.is_array() && i < names.size(); ++i) {
      const std::string place = "extensionsRequired[" + std::to_string(i) + "]";
      require(Kind::string, names[i], place);
      const std::string name = names[i];
      const auto begins = [&](std::string_view start) { return name.starts_with(start); };
      if (std::count(std::begin(kReadExtensions), std::end(kReadExtensions), name) > 0 ||
          std::any_of(std::begin(kLookExtensions), std::end(kLookExtensions), begins))
        continue;
      std::string readable;
      for (const std::string_view known : kReadExtensions) readable += std::string(known) + ", ";
      fail(place, readable + "or an extension of materials, textures or lights", name);
    }
  }

  void checkElements(std::string_view section, const Json& array, const std::string& place, bool is_nested) const {
    for (size_t i = 0; i < array.size(); ++i) {
      if (array[i].is_object()) checkMembers(section, array[i], place + "[" + std::to_string(i) + "]", is_nested);
    }
  }

  // is_nested   further down than an entry of the section itself
  void checkMembers(std::string_view section, const Json& object, const std::string& place, bool is_nested) const {
    for (const auto& [key, value] : object.items()) {
      if (key == "extras") continue;
      const std::string member = place + "." + key.substr(0, 60);
      if (key == "extensions" && value.is_object()) {
        for (const std::string_view name : kCheckedExtensions) {
          const auto extension = value.find(name);
          if (extension != value.end() && extension->is_object())
            checkMembers(section, *extension, member + "." + std::string(name), true);
        }
        continue;
      }
      const auto is_of = [&, &of_key = key](const Rule& rule) { return rule.section == section && rule.key == of_key; };
      const Rule* rule = std::find_if(std::begin(kRules), std::end(kRules), is_of);
      if (rule != std::end(kRules)) checkRule(*rule, value, member, is_nested);
      if (value.is_object()) checkMembers(section, value, member, true);
      if (value.is_array()) checkElements(section, value, member, true);
    }
  }

  void checkRule(const Rule& rule, const Json& value, const std::string& place, bool is_nested) const {
    // inside of "sparse" and of extensions, tinygltf keeps sizes in an int
    require(is_nested && rule.kind == Kind::integer ? Kind::index : rule.kind, value, place);
    if (rule.length > 0 && value.size() != rule.length)
      fail(place, std::to_string(rule.length) + " numbers", std::to_string(value.size()));
    // tinygltf looks an index accessor up before we can, and does not say whose it was
    const size_t accessor_count = root_.contains("accessors") ? root_["accessors"].size() : 0;
    if (rule.key == "indices" && value.get<uint64_t>() >= accessor_count)
      fail(place, "an accessor below " + std::to_string(accessor_count), value.dump());
  }

  void checkBuffer(const Json& buffer, size_t idx, const std::string& place) {
    if (buffer.contains("uri")) return checkUri(buffer["uri"], place + ".uri");
    if (!isFallback(buffer) && !(is_binary_ && idx == 0)) fail(place, "a uri", "none");
  }

  void checkUri(const std::string& uri, const std::string& place) {
    if (uri.starts_with("data:")) return;
    if (uri.empty()) fail(place, "a file name", "an empty uri");
    buffer_files_.push_back(uri);
  }

  const std::string& path_;
  const Json& root_;
  const bool is_binary_;
  std::vector<std::string> buffer_files_;
};

// throws   InputError on what is no JSON, nested deeper than kDeepest, or holds a key of an object twice
Json parse(const std::string& path, std::string_view text) {
  std::array<std::set<std::string>, kDeepest + 1> keys;  // by depth: of the object that is open there
  const auto check = [&](int depth, Json::parse_event_t event, const Json& parsed) {
    const bool begins = event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start;
    if (begins && depth > kDeepest) throw InputError(path, "JSON", "nesting of at most 64", "more");
    if (event == Json::parse_event_t::object_start) keys[static_cast<size_t>(depth)].clear();
    if (event != Json::parse_event_t::key) return true;
    const std::string key = parsed;
    if (!keys[static_cast<size_t>(depth - 1)].insert(key).second)
      throw InputError(path, "key \"" + key.substr(0, 60) + "\"", "each key of an object once", "it twice");
    return true;
  };
  // without the library's own name and number of the error
  const auto words = [](const std::exception& error) {
    const std::string all = error.what();
    return all.substr(std::min(all.find("] ") + 2, all.size()), 160);
  };
  try {
    return Json::parse(text, check);
  } catch (const Json::parse_error& error) {
    throw InputError(path, "byte " + std::to_string(error.byte) + " of the JSON", "JSON in UTF-8", words(error));
  } catch (const Json::exception& error) {
    throw InputError(path, "JSON", "numbers of double precision", words(error));
  }
}

// returns   whether there was something to change
bool makePlain(Json& root) {
  bool is_changed = false;
  Json none = Json::array();
  for (Json& buffer : root.contains("buffers") ? root["buffers"] : none) {
    if (buffer.contains("uri") || !isFallback(buffer)) continue;
    buffer["byteLength"] = 1;
    buffer["uri"] = "data:application/octet-stream;base64,AA==";
    is_changed = true;
  }
  for (Json& mesh : root.contains("meshes") ? root["meshes"] : none) {
    if (!mesh.contains("primitives")) continue;
    for (Json& primitive : mesh["primitives"]) {
      if (extensionOf(primitive, kDraco) == nullptr) continue;
      primitive.erase("indices");
      is_changed = true;
    }
  }
  return is_changed;
}

}  // namespace

GltfJson readGltfJson(const std::string& path, std::string_view text, bool is_binary) {
  Json root = parse(path, text);
  GltfJson found{JsonChecker(path, root, is_binary).check(), ""};
  if (makePlain(root)) found.plain_text = root.dump();
  return found;
}

}  // namespace nlg
