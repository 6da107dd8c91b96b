// Reads the materials of a glTF file, with the images that they use.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <tiny_gltf.h>
#include <glm/glm.hpp>

#include "scene/archive/scene_file.h"
#include "scene/image/image_loader.h"
#include "scene/model/oddities.h"
#include "scene/model/scene.h"

namespace nlg {

// Which of a mesh's places on images (TEXCOORD_n) a material uses, and KHR_texture_transform.
struct GltfPlacing {
  int set = -1;                                          // -1: the material has no image there
  glm::dmat3x2 from_mesh{1.0, 0.0, 0.0, 1.0, 0.0, 0.0};  // of (u, v, 1)
  bool operator==(const GltfPlacing&) const = default;
};

// Extensions of a texture that name an image of another kind than PNG and JPEG: the first is read, and goes before the plain one.
inline constexpr std::array<const char*, 4> kImageExtensions = {"EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds",
                                                                "EXT_texture_avif"};

struct GltfLooks {
  // What a mesh is to know of a material.
  struct OfVertices {
    GltfPlacing base, emissive;
    bool keeps_opacity = false;  // of its vertices' colours
    float least_opacity = 0.0f;  // of these: what is below becomes 0, and all else 1; 0: they stay as they are
  };
  // The file's, and one more for primitives without; thin where it may be transmissive (transmissive.h).
  std::vector<Material> materials;
  std::vector<std::string> names;       // of the materials
  std::vector<OfVertices> of_vertices;  // by material
  std::vector<TextureImage> images;
  bool has_base_places = false, has_emissive_places = false;  // whether any material has such an image
};

// Reads all materials, and those images that materials of the file's triangles use.
//
// budgets  files that images are read from and their pixels are taken from them
// notes    what was not read, a line each. An image that cannot be read: a mean grey stands in the place of its colours, and nothing in
//          the place of its light
// need     of images
// odd      receives material or texture, of numbers out of range, which are brought into it (of emission too much is taken as it is),
//          and of indices of what is not there: what they are part of is as an image that cannot be read
// throws   BudgetError on more bytes or pixels than the budgets hold
GltfLooks readGltfLooks(const std::string& path, const tinygltf::Model& model, SceneBudgets& budgets,
                        std::vector<std::string>* notes, Oddities* odd, ImageNeed need = ImageNeed::all);

}  // namespace nlg
