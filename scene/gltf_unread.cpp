#include "scene/gltf_unread.h"

#include <algorithm>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "scene/gltf_light.h"
#include "scene/gltf_looks.h"

namespace nlg {
namespace {

// Extensions that are read, and those that change nothing of diffuse light: what they say of mirrors, coats and choices between looks
// is no part of a scene. Those of image files are told of with the images.
constexpr std::string_view kKnownExtensions[] = {"KHR_mesh_quantization",
                                                 "EXT_meshopt_compression",
                                                 "KHR_draco_mesh_compression",
                                                 "KHR_lights_punctual",
                                                 "KHR_materials_unlit",
                                                 "KHR_materials_emissive_strength",
                                                 "KHR_materials_transmission",
                                                 "KHR_texture_transform",
                                                 "KHR_materials_pbrSpecularGlossiness",
                                                 "KHR_materials_variants",
                                                 "KHR_materials_specular",
                                                 "KHR_materials_ior",
                                                 "KHR_materials_clearcoat",
                                                 "KHR_materials_sheen",
                                                 "KHR_materials_volume",
                                                 "KHR_materials_iridescence",
                                                 "KHR_materials_anisotropy",
                                                 "KHR_materials_dispersion",
                                                 "KHR_xmp",
                                                 "KHR_xmp_json_ld"};

std::string counted(size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

// Images of base colour, emission and transmission.
std::set<int> imagesOfLight(const tinygltf::Model& model) {
  std::set<int> textures, images;
  const auto addOf = [&](const tinygltf::ExtensionMap& extensions, const char* extension, const char* key) {
    const auto found = extensions.find(extension);
    if (found == extensions.end() || !found->second.Has(key) || !found->second.Get(key).Has("index")) return;
    textures.insert(found->second.Get(key).Get("index").GetNumberAsInt());
  };
  for (const tinygltf::Material& material : model.materials) {
    textures.insert(material.pbrMetallicRoughness.baseColorTexture.index);
    textures.insert(material.emissiveTexture.index);
    addOf(material.extensions, "KHR_materials_transmission", "transmissionTexture");
    addOf(material.extensions, "KHR_materials_pbrSpecularGlossiness", "diffuseTexture");
  }
  for (const int texture : textures) {
    if (texture < 0 || static_cast<size_t>(texture) >= model.textures.size()) continue;
    const tinygltf::Texture& used = model.textures[static_cast<size_t>(texture)];
    images.insert(used.source);
    for (const char* extension : kImageExtensions) {
      const auto found = used.extensions.find(extension);
      if (found != used.extensions.end() && found->second.Has("source"))
        images.insert(found->second.Get("source").GetNumberAsInt());
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
  const auto lights = model.extensions.find("KHR_lights_punctual");
  if (lights == model.extensions.end() || !lights->second.Has("lights")) return count;
  const tinygltf::Value& list = lights->second.Get("lights");
  for (size_t i = 0; i < list.ArrayLen(); ++i) {
    const tinygltf::Value& light = list.Get(static_cast<int>(i));
    count += light.IsObject() && light.Has("extras") && hasOtherLightGroup(light.Get("extras")) ? 1 : 0;
  }
  return count;
}

}  // namespace

std::vector<std::string> unreadParts(const tinygltf::Model& model) {
  size_t morphed = 0, lines = 0, flat_cameras = 0, ranges = 0;
  for (const tinygltf::Mesh& mesh : model.meshes) {
    const auto& primitives = mesh.primitives;
    morphed += std::any_of(primitives.begin(), primitives.end(), [](const auto& p) { return !p.targets.empty(); }) ? 1 : 0;
    for (const tinygltf::Primitive& primitive : primitives)
      lines += primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES ? 1 : 0;
  }
  for (const tinygltf::Camera& camera : model.cameras) flat_cameras += camera.type == "orthographic" ? 1 : 0;
  for (const tinygltf::Light& light : model.lights) ranges += light.range > 0.0 ? 1 : 0;

  std::vector<std::string> notes;
  if (!model.animations.empty())
    notes.push_back(counted(model.animations.size(), "animation is", "animations are") +
                    " not read: all stands as the nodes have it");
  if (!model.skins.empty())
    notes.push_back(counted(model.skins.size(), "skin is", "skins are") + " not read: what hangs on them is in its rest pose");
  if (morphed > 0)
    notes.push_back(counted(morphed, "mesh has", "meshes have") + " morph targets, which are not read: it is in its rest pose");
  if (lines > 0) notes.push_back(counted(lines, "primitive is", "primitives are") + " of points or lines, which are not read");
  if (flat_cameras > 0)
    notes.push_back(counted(flat_cameras, "orthographic camera is", "orthographic cameras are") + " not read");
  if (ranges > 0)
    notes.push_back(counted(ranges, "lamp has", "lamps have") +
                    " a range, which is not read: light falls off with distance alone");
  const size_t groups = otherLightGroups(model);
  if (groups > 0)
    notes.push_back(counted(groups, "light_group among extras is", "light_groups among extras are") + " not read: no text");
  const std::set<int> looked_at = imagesOfLight(model);
  const size_t others = model.images.size() - looked_at.size();
  if (others > 0)
    notes.push_back(counted(others, "image is", "images are") + " not read: light needs none of roughness, normals and the like");
  std::set<std::string> unknown;
  for (const std::string& name : model.extensionsUsed) {
    const bool is_known = std::count(std::begin(kKnownExtensions), std::end(kKnownExtensions), name) > 0 ||
                          std::count(kImageExtensions.begin(), kImageExtensions.end(), name) > 0;
    if (!is_known) unknown.insert(name.substr(0, 60));
  }
  std::string names;
  size_t named = 0;
  for (const std::string& name : unknown) {
    if (++named <= 6) names += (named > 1 ? ", " : "") + name;
  }
  if (named > 6) names += fmt::format(" and {} more", named - 6);
  if (named > 0) notes.push_back(fmt::format("{} not read: {}", counted(named, "extension is", "extensions are"), names));
  return notes;
}

}  // namespace nlg
