#include "scene/gltf/gltf_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scene/archive/pk3_archive.h"
#include "scene/archive/scene_file.h"
#include "scene/gltf/gltf_packed.h"
#include "tool/base64.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

using Json = nlohmann::json;

constexpr int kDeepest = 64;  // nobody reads what is nested further down, as extras may be
constexpr const char* kPlainData = "data:application/octet-stream;base64,";  // as tinygltf knows it
constexpr const char *kKhrMeshopt = kMeshoptExtensions[0], *kExtMeshopt = kMeshoptExtensions[1];

// What a property is. index: below 2^31, as tinygltf keeps it; integer: below 2^53; from numbers on they are arrays, some of a length, since
// tinygltf ignores those of another.
enum class JsonKind { boolean, index, integer, number, string, object, numbers, three, four, sixteen, indices, objects };

const char* kindName(JsonKind kind) {
  constexpr std::array<const char*, 7> kNames = {"boolean", "index", "integer", "number", "string", "object", "array"};
  return kNames[std::min(static_cast<size_t>(kind), kNames.size() - 1)];
}

// 0: any.
size_t lengthOf(JsonKind kind) {
  return kind == JsonKind::three ? 3 : kind == JsonKind::four ? 4 : kind == JsonKind::sixteen ? 16 : 0;
}

// What properties must be when they are there: those that the reader depends on.
struct Rule {
  std::string_view section;
  JsonKind kind;
  std::string_view keys;  // each between blanks
};
constexpr Rule kRules[] = {{"buffers", JsonKind::string, " uri "},
                           {"buffers", JsonKind::integer, " byteLength "},
                           {"buffers", JsonKind::boolean, " fallback "},
                           {"bufferViews", JsonKind::index, " buffer byteStride count "},
                           {"bufferViews", JsonKind::integer, " byteOffset byteLength "},
                           {"bufferViews", JsonKind::string, " mode filter "},
                           {"accessors", JsonKind::index, " bufferView componentType "},
                           {"accessors", JsonKind::integer, " byteOffset count "},
                           {"accessors", JsonKind::string, " type "},
                           {"accessors", JsonKind::boolean, " normalized "},
                           {"accessors", JsonKind::object, " sparse "},
                           {"meshes", JsonKind::objects, " primitives targets "},
                           {"meshes", JsonKind::object, " attributes "},
                           {"meshes", JsonKind::index, " bufferView POSITION "},
                           {"meshes", JsonKind::index, " indices material mode "},
                           {"meshes", JsonKind::numbers, " weights "},
                           {"nodes", JsonKind::index, " mesh skin "},
                           {"nodes", JsonKind::indices, " children "},
                           {"nodes", JsonKind::numbers, " weights "},
                           {"nodes", JsonKind::three, " translation scale "},
                           {"nodes", JsonKind::four, " rotation "},
                           {"nodes", JsonKind::sixteen, " matrix "},
                           {"skins", JsonKind::indices, " joints "},
                           {"skins", JsonKind::index, " inverseBindMatrices "},
                           {"scenes", JsonKind::indices, " nodes "},
                           {"materials", JsonKind::object, " pbrMetallicRoughness "},
                           {"materials", JsonKind::object, " baseColorTexture "},
                           {"materials", JsonKind::object, " emissiveTexture "},
                           {"materials", JsonKind::four, " baseColorFactor "},
                           {"materials", JsonKind::three, " emissiveFactor "},
                           {"materials", JsonKind::boolean, " doubleSided "},
                           {"materials", JsonKind::string, " alphaMode "},
                           {"materials", JsonKind::number, " alphaCutoff "},
                           {"materials", JsonKind::number, " transmissionFactor "},
                           {"materials", JsonKind::number, " emissiveStrength "},
                           {"materials", JsonKind::index, " index texCoord "},
                           {"textures", JsonKind::index, " source sampler "},
                           {"samplers", JsonKind::index, " wrapS wrapT "},
                           {"images", JsonKind::string, " uri "},
                           {"images", JsonKind::index, " bufferView "}};

// What stands in the place of an element that breaks a rule, and is then found to be nothing; null: the file is refused.
struct Section {
  const char *name, *blank;
  bool is_look = false;  // a member that breaks a rule is left out alone
};
constexpr Section kSections[] = {{"buffers", nullptr},
                                 {"bufferViews", R"({"buffer":0,"byteLength":1})"},
                                 {"accessors", R"({"componentType":5126,"count":1,"type":"SCALAR"})"},
                                 {"meshes", R"({"primitives":[]})"},
                                 {"nodes", "{}"},
                                 {"skins", R"({"joints":[]})"},
                                 {"scenes", R"({"nodes":[]})"},
                                 {"cameras", R"({"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"zfar":2,"znear":1}})"},
                                 {"materials", "{}", true},
                                 {"textures", "{}", true},
                                 {"samplers", "{}", true},
                                 {"images", R"({"uri":""})"}};
constexpr const char *kMended = "against the format: left out", *kEmpty = "what lies in it is left out";

// Extensions whose members the rules hold for, too; whatever else stands in an extension is anybody's.
constexpr std::string_view kCheckedExtensions[] = {"KHR_materials_emissive_strength",
                                                   "KHR_materials_transmission",
                                                   "EXT_texture_webp",
                                                   "KHR_texture_basisu",
                                                   kDraco,
                                                   kKhrMeshopt,
                                                   kExtMeshopt};

// Extensions that a file may require: those that the reader follows, and, by the beginnings of their names, those that can be missing:
// of looks, of what nodes do when someone plays, of what is known of them. Any other may change where triangles are.
constexpr std::string_view kReadExtensions[] = {"KHR_mesh_quantization",   kExtMeshopt,           kKhrMeshopt, kDraco,
                                                "EXT_mesh_gpu_instancing", "KHR_node_visibility", "MSFT_lod"};
constexpr std::string_view kOtherExtensions[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",  "KHR_lights_",
                                                 "KHR_node_",      "KHR_physics_", "KHR_animation", "KHR_interactivity",
                                                 "KHR_xmp",        "OMI_"};

bool isOf(JsonKind kind, const Json& value) {
  const auto isBelow = [&](int bits) { return value.is_number_unsigned() && value.get<uint64_t>() < uint64_t{1} << bits; };
  return kind == JsonKind::boolean   ? value.is_boolean()
         : kind == JsonKind::index   ? isBelow(31)
         : kind == JsonKind::integer ? isBelow(53)
         : kind == JsonKind::number  ? value.is_number()
         : kind == JsonKind::string  ? value.is_string()
         : kind == JsonKind::object  ? value.is_object()
                                     : value.is_array();
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
  return std::any_of(std::begin(kMeshoptExtensions), std::end(kMeshoptExtensions), [&](const char* name) {
    const Json* extension = extensionOf(buffer, name);
    return extension != nullptr && extension->is_object() && extension->value("fallback", false);
  });
}

class JsonChecker {
 public:
  JsonChecker(const std::string& path, Json& root, bool has_bin, Oddities* odd)
      : path_(path), root_(root), has_bin_(has_bin), odd_(*odd) {}

  std::vector<std::string> check() {
    require(JsonKind::object, root_, "root");
    uses_meshopt_ = root_.value("extensionsUsed", Json()).dump().find("_meshopt_") != std::string::npos;
    // of glTF 1.0 nothing else fits
    if (root_.contains("asset") && root_["asset"].is_object() && root_["asset"].contains("version")) {
      const Json& version = root_["asset"]["version"];
      if (version.is_string() && !version.get<std::string>().starts_with("2"))
        fail("asset.version", "2.0", version.get<std::string>());
    }
    checkRequiredExtensions();
    if (root_.contains("scene")) require(JsonKind::index, root_["scene"], "scene");
    for (const Section& section : kSections) {
      if (!root_.contains(section.name)) continue;
      if (section.blank == nullptr) require(JsonKind::objects, root_[section.name], section.name);
      if (!root_[section.name].is_array()) fail(section.name, "a JSON array", root_[section.name].type_name());
      for (size_t i = 0; i < root_[section.name].size(); ++i)
        checkElement(section, root_[section.name][i], fmt::format("{}[{}]", section.name, i));
    }
    mendLights();
    for (size_t i = 0; i < countOf("buffers"); ++i) checkBuffer(root_["buffers"][i], i, "buffers[" + std::to_string(i) + "]");
    return std::move(buffer_files_);
  }
  bool isChanged() const { return is_changed_; }

 private:
  [[noreturn]] void fail(const std::string& place, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place, expected, got.substr(0, 80));
  }

  void require(JsonKind kind, const Json& value, const std::string& place) const {
    if (!isOf(kind, value))
      fail(place, std::string("a JSON ") + kindName(kind), value.is_structured() ? value.type_name() : value.dump());
    for (size_t i = 0; kind >= JsonKind::numbers && i < value.size(); ++i) {
      const JsonKind element = kind == JsonKind::indices   ? JsonKind::index
                               : kind == JsonKind::objects ? JsonKind::object
                                                           : JsonKind::number;
      if (!isOf(element, value[i])) require(element, value[i], place + "[" + std::to_string(i) + "]");
    }
  }

  // Before whatever else a file lacks: that may be what the extension provides for.
  void checkRequiredExtensions() const {
    const Json names = root_.value("extensionsRequired", Json::array());
    for (size_t i = 0; names.is_array() && i < names.size(); ++i) {
      const std::string place = "extensionsRequired[" + std::to_string(i) + "]";
      require(JsonKind::string, names[i], place);
      const std::string name = names[i];
      const auto begins = [&](std::string_view start) { return name.starts_with(start); };
      if (std::count(std::begin(kReadExtensions), std::end(kReadExtensions), name) > 0 ||
          std::any_of(std::begin(kOtherExtensions), std::end(kOtherExtensions), begins))
        continue;
      std::string readable;
      for (const std::string_view known : kReadExtensions) readable += std::string(known) + ", ";
      fail(place, readable + "or an extension of looks or of what is done with nodes", name);
    }
  }

  void checkElement(const Section& section, Json& element, const std::string& place) {
    const auto check = [&] {
      require(JsonKind::object, element, place);
      checkMembers(section, element, place, false);
      if (!isWhole(section.name, element, place)) fail(place, "all members that glTF requires", element.dump());
    };
    if (section.blank == nullptr) return check();
    if (odd_.attempt(kMended, check)) return;
    const Json name = element.is_object() ? element.value("name", Json("")) : Json("");
    element = Json::parse(section.blank);
    element["name"] = name.is_string() ? name : "";
    is_changed_ = true;
  }

  size_t countOf(const char* section) const { return root_.contains(section) ? root_[section].size() : 0; }
  bool isBelow(const Json& object, const char* key, const char* section) const {
    return object.contains(key) && object[key].is_number_unsigned() && object[key] < countOf(section);
  }

  // What tinygltf refuses a file for.
  bool isWhole(std::string_view name, const Json& element, const std::string& place) {
    const auto has = [&](const char* key) { return element.contains(key); };
    const auto isOneOf = [&](const char* key, std::initializer_list<std::string_view> texts) {
      return has(key) && element[key].is_string() && std::count(texts.begin(), texts.end(), element[key].get<std::string>()) > 0;
    };
    if (name == "nodes" && has("matrix") && (has("translation") || has("rotation") || has("scale")))
      odd_.add("the matrix counts", place + ": a matrix, and translation, rotation or scale beside it");
    if (name == "bufferViews") return has("byteLength") && isBelow(element, "buffer", "buffers");
    if (name == "accessors")
      return has("count") && has("componentType") && element["componentType"] >= 5120 && element["componentType"] <= 5126 &&
             isOneOf("type", {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"});
    if (name == "skins") return has("joints");
    if (name == "images") return has("uri") ? !has("bufferView") : isBelow(element, "bufferView", "bufferViews");
    if (name != "cameras") return true;
    if (!isOneOf("type", {"perspective", "orthographic"})) return false;
    const Json lens = element.value(element["type"].get<std::string>(), Json());
    const auto isNumber = [&](const char* key) { return lens.is_object() && lens.contains(key) && lens[key].is_number(); };
    const bool is_flat = element["type"] == "orthographic";
    return isNumber("znear") && (is_flat ? isNumber("xmag") && isNumber("ymag") && isNumber("zfar") : isNumber("yfov"));
  }

  // Of its lights tinygltf asks for a type and, where they are spots, for cones.
  void mendLights() {
    const Json::json_pointer place("/extensions/KHR_lights_punctual/lights");
    if (!root_.contains(place) || !root_[place].is_array()) return;
    for (Json& light : root_[place]) {
      const bool has_type = light.is_object() && light.contains("type") && light["type"].is_string();
      const bool lacks_cones = has_type && light["type"] == "spot" && !(light.contains("spot") && light["spot"].is_object());
      if (!light.is_object()) light = Json::object();
      if (!has_type) light["type"] = "none";
      if (lacks_cones) light["spot"] = Json::object();
      is_changed_ = is_changed_ || !has_type || lacks_cones;
    }
  }

  void checkElements(const Section& section, Json& array, const std::string& place, bool is_nested) {
    for (size_t i = 0; i < array.size(); ++i) {
      if (!array[i].is_object()) continue;
      const auto check = [&] {
        checkMembers(section, array[i], place + "[" + std::to_string(i) + "]", is_nested);
        const bool has_indices = place.ends_with(".primitives") && array[i].contains("indices") && !extensionOf(array[i], kDraco);
        // tinygltf looks them up before we can, and does not say whose they were
        if (has_indices && !(isBelow(array[i], "indices", "accessors") &&
                             isBelow(root_["accessors"][array[i]["indices"].get<size_t>()], "bufferView", "bufferViews")))
          fail(place + "[" + std::to_string(i) + "].indices", "an accessor with a bufferView", array[i]["indices"].dump());
      };
      if (!place.ends_with(".primitives")) {
        check();
      } else if (!odd_.attempt(kMended, check)) {
        array[i] = {{"attributes", Json::object()}};
        is_changed_ = true;
      }
    }
  }

  // is_nested   further down than an entry of the section itself
  void checkMembers(const Section& section, Json& object, const std::string& place, bool is_nested) {
    std::vector<std::string> broken;
    for (auto& [key, value] : object.items()) {
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
      const auto is_of = [&, word = " " + key + " "](const Rule& rule) {
        return rule.section == section.name && rule.keys.find(word) != std::string_view::npos;
      };
      const Rule* rule = std::find_if(std::begin(kRules), std::end(kRules), is_of);
      const auto check = [&, &of = value, &of_key = key] { checkRule(*rule, of_key, of, member, is_nested); };
      if (rule != std::end(kRules) && !section.is_look) check();
      if (rule != std::end(kRules) && section.is_look && !odd_.attempt(kMended, check)) {
        broken.push_back(key);
        continue;
      }
      if (value.is_object()) checkMembers(section, value, member, true);
      if (value.is_array()) checkElements(section, value, member, true);
    }
    for (const std::string& key : broken) object.erase(key);
    is_changed_ = is_changed_ || !broken.empty();
  }

  // Programs whose numbers are all floats write 24.0.
  void makeInteger(JsonKind kind, Json& value) {
    if (kind == JsonKind::indices && value.is_array()) {
      for (Json& one : value) makeInteger(JsonKind::index, one);
    }
    if ((kind != JsonKind::index && kind != JsonKind::integer) || !value.is_number_float()) return;
    const double number = value;
    if (!(number >= 0.0 && number < 0x1p53 && number == std::floor(number))) return;
    value = static_cast<uint64_t>(number);
    is_changed_ = true;
  }

  void checkRule(const Rule& rule, const std::string& key, Json& value, const std::string& place, bool is_nested) {
    makeInteger(rule.kind, value);
    // inside of "sparse" and of extensions, tinygltf keeps sizes in an int
    require(is_nested && rule.kind == JsonKind::integer ? JsonKind::index : rule.kind, value, place);
    if (key == "attributes") {
      for (const auto& [name, accessor] : value.items()) require(JsonKind::index, accessor, place + "." + name);
    }
    const size_t length = lengthOf(rule.kind);
    if (length > 0 && value.size() != length) fail(place, std::to_string(length) + " numbers", std::to_string(value.size()));
    // tinygltf looks an index accessor up before we can, and does not say whose it was
    if (key == "indices" && value.get<uint64_t>() >= countOf("accessors"))
      fail(place, "an accessor below " + std::to_string(countOf("accessors")), value.dump());
  }

  void checkBuffer(Json& buffer, size_t idx, const std::string& place) {
    const bool has_uri = buffer.contains("uri");
    if (has_bin_ && idx == 0 && !has_uri && !isFallback(buffer)) return;
    if (has_uri && odd_.attempt(kEmpty, [&] { findBytes(buffer, place); })) return;
    // a fallback need not be marked as one
    if (!has_uri && !isFallback(buffer) && !uses_meshopt_) odd_.add(kEmpty, place + ": a buffer without a uri");
    // tinygltf demands an address and bytes of every buffer
    setBytes(buffer, 1, std::string(kPlainData) + "AA==");
  }

  void setBytes(Json& buffer, uint64_t count, const std::string& uri) {
    is_changed_ = is_changed_ || buffer.value("byteLength", uint64_t{0}) != count || buffer["uri"] != uri;
    buffer["byteLength"] = count;
    buffer["uri"] = uri;
  }

  void findBytes(Json& buffer, const std::string& place) {
    const std::string uri = buffer["uri"];
    std::string bytes;
    if (isDataUri(uri)) {
      if (!dataOfUri(uri, &bytes)) fail(place + ".uri", "a data URI (RFC 2397) of a byte or more", uri);
      return setBytes(buffer, bytes.size(), kPlainData + base64(bytes));
    }
    const FileBeside file = findBeside(path_, uri);
    const std::string name = "buffer \"" + uri.substr(0, 80) + "\"";
    if (file.path.empty()) fail(name, "a file in the folder or below", "one that " + file.problem);
    if (!file.guess.empty()) odd_.add("read by another name than its address", name + " from " + file.guess);
    const uint64_t size = InputFile(file.path, name).size();
    if (size == 0) fail(name, "a byte or more", "an empty file");
    setBytes(buffer, size, uri);
    buffer_files_.push_back(file.path);
  }

  const std::string& path_;
  Json& root_;
  const bool has_bin_;
  Oddities& odd_;
  bool is_changed_ = false, uses_meshopt_ = false;
  std::vector<std::string> buffer_files_;
};

// is_cut   receives whether something is nested deeper than kDeepest, and left out
// throws   InputError on what is no JSON, or holds a key of an object twice
Json parse(const std::string& path, std::string_view text, bool* is_cut) {
  std::array<std::set<std::string>, kDeepest + 1> keys;  // by depth: of the object that is open there
  const auto check = [&](int depth, Json::parse_event_t event, const Json& parsed) {
    *is_cut = *is_cut || depth > kDeepest;
    if (depth > kDeepest) return false;
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
  // tinygltf refuses a file for one image that it cannot decode: it keeps what it takes for a file's name
  for (Json& image : root.contains("images") ? root["images"] : none) {
    if (!image.contains("uri") || !isDataUri(image["uri"])) continue;
    image["uri"] = "DATA" + image["uri"].get<std::string>().substr(4);
    is_changed = true;
  }
  // nobody reads animations, but they count
  if (root.contains("animations")) {
    const size_t count = root["animations"].is_array() ? root["animations"].size() : 0;
    root["animations"] = Json(count, Json{{"channels", none}, {"samplers", none}});
    is_changed = true;
  }
  // Draco's indices may have no buffer view, which tinygltf refuses
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

bool isDataUri(const std::string& uri) { return lowerCase(uri.substr(0, 5)) == "data:"; }

bool dataOfUri(const std::string& uri, std::string* bytes) {
  // a comma may stand in a parameter's quotes
  size_t comma = 0;
  for (bool is_quoted = false; comma < uri.size() && (is_quoted || uri[comma] != ','); ++comma) is_quoted ^= uri[comma] == '"';
  if (comma == uri.size()) return false;
  *bytes = percentDecoded(uri.substr(comma + 1));
  const bool is_base64 = lowerCase(uri.substr(0, comma)).ends_with(";base64");
  return (!is_base64 || fromBase64(std::string(*bytes), bytes)) && !bytes->empty();
}

GltfJson readGltfJson(const std::string& path, std::string_view text, bool has_bin, Oddities* odd) {
  bool is_cut = false;
  Json root = parse(path, text, &is_cut);
  JsonChecker checker(path, root, has_bin, odd);
  GltfJson found{checker.check(), ""};
  if (makePlain(root) || checker.isChanged() || is_cut) found.plain_text = root.dump();
  return found;
}

}  // namespace nlg
