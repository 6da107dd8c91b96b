#include "scene/gltf/gltf_unread.h"

#include <algorithm>
#include <map>
#include <string_view>

#include <fmt/format.h>

#include "scene/gltf/gltf_light.h"
#include "scene/gltf/gltf_looks.h"
#include "scene/gltf/gltf_nodes.h"
#include "scene/model/oddities.h"

namespace nlg {
namespace {

// Extensions that are read, and those that change nothing of what is emitted, absorbed or let through, up to what mirrors do: by the
// beginnings of their names. Those of image files are told of with the images.
constexpr std::string_view kKnownExtensions[] = {
    "KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_draco_mesh_compression",
    "EXT_mesh_gpu_instancing", "KHR_node_visibility", "MSFT_lod", "KHR_lights_punctual", "KHR_materials_unlit",
    "KHR_materials_emissive_strength", "KHR_materials_transmission", "KHR_texture_transform",
    "KHR_materials_pbrSpecularGlossiness",
    // choices between looks; mirrors and how they bend, of which diffuse light knows nothing
    "KHR_materials_variants", "KHR_materials_specular", "KHR_materials_ior", "KHR_materials_iridescence",
    "KHR_materials_anisotropy", "KHR_materials_dispersion", "ADOBE_materials_clearcoat", "MSFT_packing_",
    // what is done with nodes, heard of them and known of them
    "KHR_animation_pointer", "KHR_node_", "KHR_interactivity", "KHR_physics_", "KHR_implicit_shapes", "KHR_audio", "OMI_",
    "KHR_xmp", "EXT_mesh_manifold", "EXT_mesh_primitive_edge_visibility", "CESIUM_primitive_outline", "FB_geometry_metadata",
    "EXT_structural_metadata", "EXT_mesh_features", "EXT_instance_features", "GODOT_single_root", "AGI_", "GRIFFEL_bim_data"};

// Extensions that make something wrong. Most change nothing of a material until a factor is another than this.
struct WrongBy {
  std::string_view name;
  const char *how, *factor = "";
  double nothing = 0.0;
};
constexpr WrongBy kWrongBy[] = {
    {"KHR_materials_volume", "absorbs nothing of what goes through, where it should", "attenuationColor", 1.0},
    {"KHR_materials_diffuse_transmission", "lets no light through, where it should", "diffuseTransmissionFactor"},
    {"KHR_materials_sheen", "sends back its base colour alone, without its sheen", "sheenColorFactor"},
    {"KHR_materials_clearcoat", "shines as without its coat, which takes 4 % of it or more", "clearcoatFactor"},
    {"ADOBE_materials_thin_transparency", "lets no light through, where it should"},
    {"EXT_lights_ies", "shines all round or not at all, not by its profile"},
    {"EXT_lights_image_based", "lacks the light of its image (--sky gives one)"}};

// Whether a number, or any of a colour's, is another than what changes nothing.
bool isOther(const tinygltf::Value& object, const std::string& key, double nothing) {
  const tinygltf::Value& value = object.Get(key);
  const auto is = [&](const tinygltf::Value& number) { return number.IsNumber() && number.GetNumberAsDouble() != nothing; };
  bool is_other = is(value);
  for (size_t i = 0; value.IsArray() && i < value.ArrayLen(); ++i) is_other = is_other || is(value.Get(static_cast<int>(i)));
  return is_other;
}

bool isWrong(const WrongBy& by, const tinygltf::Value& extension, const tinygltf::Material& material) {
  const std::vector<double>& emission = material.emissiveFactor;
  // what is solid absorbs all, what is thin nothing, and without a distance nor does the rest; a coat is a mirror but to what shines
  const bool absorbs = material.extensions.count("KHR_materials_transmission") > 0 &&
                       isOther(extension, "thicknessFactor", 0.0) && extension.Has("attenuationDistance");
  if (by.name == "KHR_materials_volume" && !absorbs) return false;
  if (by.name == "KHR_materials_clearcoat" && *std::max_element(emission.begin(), emission.end()) <= 0.0) return false;
  return *by.factor == '\0' || isOther(extension, by.factor, by.nothing);
}

// Of one that is used and not read: the materials, objects and lamps that have it, and how they are wrong; empty where none is.
std::string wrongLine(const tinygltf::Model& model, const std::set<int>& used_materials, const std::string& name) {
  const auto known = std::find_if(std::begin(kWrongBy), std::end(kWrongBy), [&](const WrongBy& by) { return by.name == name; });
  const bool is_known = known != std::end(kWrongBy);
  std::map<std::string, std::vector<std::string>> wrong;  // by what they are
  const auto collect = [&](const char* what, const auto& parts) {
    for (size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].extensions.count(name) > 0) wrong[what].push_back(parts[i].name.empty() ? std::to_string(i) : parts[i].name);
    }
  };
  // of materials only those that triangles have, and of these only where the extension changes the picture
  for (const int m : used_materials) {
    if (static_cast<size_t>(m) >= model.materials.size()) continue;  // that of triangles without
    const tinygltf::Material& material = model.materials[static_cast<size_t>(m)];
    const auto extension = material.extensions.find(name);
    if (extension == material.extensions.end()) continue;
    if (is_known && !isWrong(*known, extension->second, material)) continue;
    wrong["material"].push_back(material.name.empty() ? std::to_string(m) : material.name);
  }
  const auto hasIt = [&](const auto& part) { return part.extensions.count(name) > 0; };
  // nodes stand for their meshes, and lamps for themselves: users know objects by name
  std::set<int> meshes;
  for (size_t i = 0; i < model.meshes.size(); ++i) {
    const tinygltf::Mesh& mesh = model.meshes[i];
    if (hasIt(mesh) || std::any_of(mesh.primitives.begin(), mesh.primitives.end(), hasIt)) meshes.insert(static_cast<int>(i));
  }
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    const tinygltf::Node& node = model.nodes[i];
    const bool is_lamp = node.extensions.count("KHR_lights_punctual") > 0 || name.find("_lights_") != std::string::npos;
    if (hasIt(node) || meshes.count(node.mesh) > 0)
      wrong[is_lamp ? "lamp" : "object"].push_back(nodeName(model, static_cast<int>(i)));
  }
  collect("lamp", model.lights);
  collect("texture", model.textures);
  collect("scene", model.scenes);
  // what has it, by kind; a known extension that nothing has is passed over
  std::string line;
  for (const auto& [what, names] : wrong)
    line += (line.empty() ? "" : ", ") + counted(names.size(), what, what + "s") + " (" + listed(names) + ")";
  if (wrong.empty()) return is_known ? "" : name + " is not read; no material, object or lamp has it";
  return fmt::format("{} is not read: {}: {}", name, line, is_known ? known->how : "may be wrong");
}

// Images of base colour, emission and transmission.
std::set<int> imagesOfLight(const tinygltf::Model& model) {
  std::set<int> textures, images;
  const auto addOf = [&](const tinygltf::ExtensionMap& extensions, const char* extension, const char* key) {
    const tinygltf::Value* texture = memberOf(extensions, extension, key);
    if (texture != nullptr && texture->Has("index")) textures.insert(texture->Get("index").GetNumberAsInt());
  };
  // what light reads of a material, in the core and in extensions of it
  for (const tinygltf::Material& material : model.materials) {
    textures.insert(material.pbrMetallicRoughness.baseColorTexture.index);
    textures.insert(material.emissiveTexture.index);
    addOf(material.extensions, "KHR_materials_transmission", "transmissionTexture");
    addOf(material.extensions, "KHR_materials_pbrSpecularGlossiness", "diffuseTexture");
  }
  // an extension may replace a texture's source by an image of another format
  for (const int texture : textures) {
    if (texture < 0 || static_cast<size_t>(texture) >= model.textures.size()) continue;
    const tinygltf::Texture& used = model.textures[static_cast<size_t>(texture)];
    images.insert(used.source);
    for (const char* extension : kImageExtensions) {
      const tinygltf::Value* source = memberOf(used.extensions, extension, "source");
      if (source != nullptr) images.insert(source->GetNumberAsInt());
    }
  }
  std::erase_if(images, [&](int image) { return image < 0 || static_cast<size_t>(image) >= model.images.size(); });
  return images;
}

bool hasOtherLightGroup(const tinygltf::Value& extras) {
  return extras.IsObject() && extras.Has(kLightGroupKey) && !extras.Get(kLightGroupKey).IsString();
}

// Of lights, nodes and materials.
size_t otherLightGroups(const tinygltf::Model& model) {
  size_t count = 0;
  for (const tinygltf::Node& node : model.nodes) count += hasOtherLightGroup(node.extras) ? 1 : 0;
  for (const tinygltf::Material& material : model.materials) count += hasOtherLightGroup(material.extras) ? 1 : 0;
  const tinygltf::Value* list = memberOf(model.extensions, "KHR_lights_punctual", "lights");
  for (size_t i = 0; list != nullptr && i < list->ArrayLen(); ++i) {
    const tinygltf::Value& light = list->Get(static_cast<int>(i));
    count += light.IsObject() && light.Has("extras") && hasOtherLightGroup(light.Get("extras")) ? 1 : 0;
  }
  return count;
}

}  // namespace

std::vector<std::string> unreadParts(const tinygltf::Model& model, const std::set<int>& used_materials) {
  // what the format holds and light does not read
  size_t lines = 0, flat_cameras = 0, ranges = 0;
  for (const tinygltf::Mesh& mesh : model.meshes) {
    for (const tinygltf::Primitive& primitive : mesh.primitives)
      lines += primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES ? 1 : 0;
  }
  for (const tinygltf::Camera& camera : model.cameras) flat_cameras += camera.type == "orthographic" ? 1 : 0;
  for (const tinygltf::Light& light : model.lights) ranges += light.range > 0.0 ? 1 : 0;

  std::vector<std::string> notes;
  const auto note = [&](size_t count, const char* one, const char* many, const char* rest) {
    if (count > 0) notes.push_back(counted(count, one, many) + rest);
  };
  // one line a kind, with its count: none is passed over in silence
  note(model.animations.size(), "animation is", "animations are", " not read: all stands as the nodes have it");
  note(lines, "primitive is", "primitives are", " of points or lines, which are not read");
  note(flat_cameras, "orthographic camera is", "orthographic cameras are", " not read");
  note(ranges, "lamp has", "lamps have", " a range, which is not read: light falls off with distance alone");
  note(otherLightGroups(model), "light_group among extras is", "light_groups among extras are", " not read: no text");
  note(model.images.size() - imagesOfLight(model).size(), "image is", "images are",
       " not read: light needs none of roughness, normals and the like");
  // extensions of the list and of materials
  std::set<std::string> all(model.extensionsUsed.begin(), model.extensionsUsed.end());
  // programs forget to say so
  for (const tinygltf::Material& material : model.materials) {
    for (const auto& [name, extension] : material.extensions) all.insert(name);
  }
  std::vector<std::string> names;
  for (const std::string& used : all) {
    const auto begins = [&](std::string_view known) { return used.starts_with(known); };
    const bool is_known = std::any_of(std::begin(kKnownExtensions), std::end(kKnownExtensions), begins) ||
                          std::count(kImageExtensions.begin(), kImageExtensions.end(), used) > 0;
    if (!is_known) names.push_back(used.substr(0, 60));
  }
  constexpr size_t kMostLines = 20;
  for (size_t i = 0; i < std::min(names.size(), kMostLines); ++i) {
    const std::string line = wrongLine(model, used_materials, names[i]);
    if (!line.empty()) notes.push_back(line);
  }
  note(std::max(names.size(), kMostLines) - kMostLines, "more extension is", "more extensions are", " not read");
  return notes;
}

}  // namespace nlg
