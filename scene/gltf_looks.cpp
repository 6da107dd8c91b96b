// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#materials and the extensions beside it
#include "scene/gltf_looks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "scene/gltf_accessor.h"
#include "scene/gltf_json.h"
#include "scene/gltf_light.h"
#include "scene/scene_file.h"
#include "tool/base64.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

constexpr int kMostSets = 64;  // TEXCOORD_n

// What a material says of one of its images.
struct TextureInfo {
  std::string place;  // for errors
  int texture = -1;
  GltfPlacing placing;
};

const tinygltf::Value* extensionOf(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found == extensions.end() || !found->second.IsObject() ? nullptr : &found->second;
}

// One of the file's images: its name in notes, unlike all others, and where its bytes are.
class GltfImages {
 public:
  GltfImages(const std::string& path, const tinygltf::Model& model, SceneBudget& bytes_left)
      : path_(path), model_(model), bytes_left_(bytes_left) {
    for (size_t i = 0; i < model.images.size(); ++i) {
      const tinygltf::Image& image = model.images[i];
      const bool has_file = !image.uri.empty() && !image.uri.starts_with("data:");
      std::string name = has_file ? image.uri : image.name;
      if (name.empty() || index_.count(name) > 0) name += fmt::format("{}image {}", name.empty() ? "" : ", ", i);
      index_.emplace(name, i);
      names_.push_back(std::move(name));
    }
  }

  const std::string& name(size_t image) const { return names_[image]; }

  ImageBytes open(const std::string& name) const {
    const size_t idx = index_.at(name);
    const tinygltf::Image& image = model_.images[idx];
    ImageBytes bytes;
    if (image.bufferView >= 0) {
      bytes.elsewhere = bytesOfView(model_, image.bufferView, path_, fmt::format("images[{}]: bufferView", idx));
    } else if (image.uri.starts_with("data:")) {
      const size_t comma = image.uri.find(";base64,");
      std::string decoded;
      if (comma == std::string::npos || !fromBase64(std::string_view(image.uri).substr(comma + 8), &decoded))
        bytes.problem = "has a data URI that is no base64";
      bytes.own.assign(decoded.begin(), decoded.end());
    } else if (!image.uri.empty()) {
      bytes = imageBeside(path_, image.uri, bytes_left_);
    } else {
      bytes.elsewhere = image.image;  // of a data URI
    }
    return bytes;
  }

 private:
  const std::string& path_;
  const tinygltf::Model& model_;
  SceneBudget& bytes_left_;
  std::vector<std::string> names_;
  std::map<std::string, size_t> index_;
};

class LooksReader {
 public:
  LooksReader(const std::string& path, const tinygltf::Model& model, SceneBudgets& budgets, std::vector<std::string>* notes,
              ImageNeed need)
      : path_(path), model_(model), budgets_(budgets), notes_(notes), images_(path, model, budgets.bytes), loader_(need) {}

  GltfLooks read() {
    const std::set<int> used = usedMaterials();
    for (size_t i = 0; i < model_.materials.size(); ++i) {
      place_ = "material " + std::to_string(i);
      looks_.names.push_back(model_.materials[i].name);
      readMaterial(model_.materials[i], used.count(static_cast<int>(i)) > 0);
    }
    // what glTF gives to a primitive without a material
    Material none;
    none.base_color = glm::vec3(1.0f);
    looks_.materials.push_back(none);
    looks_.of_vertices.emplace_back();
    looks_.names.emplace_back("no material");
    loadImages();
    return std::move(looks_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& expected, const std::string& got) const {
    throw InputError(path_, place_ + ": " + what, expected, got);
  }

  float checkedFactor(double value, double limit, const std::string& what) const {
    // the tolerance is for factors that an exporter computed in float
    if (!(value >= 0.0 && value <= limit * 1.001))
      fail(what, "a number from 0 to " + std::to_string(limit), std::to_string(value));
    return static_cast<float>(std::min(value, limit));
  }

  // A number in an extension; the text has not been held against a format there.
  double numberIn(const tinygltf::Value& object, const char* key, double fallback) const {
    if (!object.Has(key)) return fallback;
    if (!object.Get(key).IsNumber()) fail(key, "a number", "something else");
    return object.Get(key).GetNumberAsDouble();
  }

  glm::dvec2 pairIn(const tinygltf::Value& object, const char* key, const glm::dvec2& fallback) const {
    if (!object.Has(key)) return fallback;
    const tinygltf::Value& pair = object.Get(key);
    if (!pair.IsArray() || pair.ArrayLen() != 2 || !pair.Get(0).IsNumber() || !pair.Get(1).IsNumber())
      fail(key, "two numbers", "something else");
    return {pair.Get(0).GetNumberAsDouble(), pair.Get(1).GetNumberAsDouble()};
  }

  int indexIn(const tinygltf::Value& object, const char* key, int fallback) const {
    const double number = numberIn(object, key, fallback);
    if (!(number >= -1.0 && number < 0x1p31)) fail(key, "an index", std::to_string(number));
    return static_cast<int>(number);
  }

  // Materials of what becomes triangles.
  std::set<int> usedMaterials() const {
    std::set<int> used;
    for (const tinygltf::Mesh& mesh : model_.meshes) {
      for (const tinygltf::Primitive& primitive : mesh.primitives) {
        if (primitive.mode >= TINYGLTF_MODE_TRIANGLES) used.insert(primitive.material);
      }
    }
    return used;
  }

  void readMaterial(const tinygltf::Material& source, bool is_used) {
    Material material;
    GltfLooks::OfVertices of_vertices;
    material.double_sided = source.doubleSided;
    std::vector<double> base = source.pbrMetallicRoughness.baseColorFactor;
    TextureInfo base_info = infoOf(source.pbrMetallicRoughness.baseColorTexture, "baseColorTexture");
    // what stands in the place of the rest in files from before 2019
    if (const tinygltf::Value* old = extensionOf(source.extensions, "KHR_materials_pbrSpecularGlossiness")) {
      if (old->Has("diffuseFactor")) base = fourIn(*old, "diffuseFactor");
      if (old->Has("diffuseTexture")) base_info = infoIn(*old, "diffuseTexture");
    }
    for (int channel = 0; channel < 3; ++channel)
      material.base_color[channel] = checkedFactor(base[static_cast<size_t>(channel)], 1.0, "baseColorFactor");
    readEmission(source, is_used, &material, &of_vertices);
    readVeil(source, base[3], &material, &of_vertices);
    KeptAs kept;
    if (material.veil != Veil::none && source.alphaMode == "BLEND") kept.opacity = KeptAs::Opacity::mean;
    if (material.veil != Veil::none && source.alphaMode == "MASK") {
      kept.opacity = KeptAs::Opacity::cut;
      kept.least_code = leastCode(of_vertices.least_opacity);
      // cut at the texels, not at the factor
      if (base_info.texture >= 0) material.opacity = 1.0f;
    }
    if (is_used) use(base_info, kept, &material.base_image, &of_vertices.base);
    if (is_used) readTransmissionImage(source, &material, &of_vertices);
    looks_.materials.push_back(material);
    looks_.of_vertices.push_back(of_vertices);
  }

  void readEmission(const tinygltf::Material& source, bool is_used, Material* material, GltfLooks::OfVertices* of_vertices) {
    material->label = {source.name, lightGroupOf(source.extras)};
    const tinygltf::Value* extension = extensionOf(source.extensions, "KHR_materials_emissive_strength");
    const double strength =
        extension == nullptr ? 1.0 : checkedFactor(numberIn(*extension, "emissiveStrength", 1.0), 1e12, "emissiveStrength");
    for (int channel = 0; channel < 3; ++channel) {
      const double factor = checkedFactor(source.emissiveFactor[static_cast<size_t>(channel)], 1.0, "emissiveFactor");
      material->emissive[channel] = static_cast<float>(strength * factor);
    }
    const TextureInfo info = infoOf(source.emissiveTexture, "emissiveTexture");
    // it is drawn as it is, without light: neither its own
    if (extensionOf(source.extensions, "KHR_materials_unlit") != nullptr) material->emissive = glm::vec3(0.0f);
    if (is_used && material->emissive != glm::vec3(0.0f)) use(info, {}, &material->emissive_image, &of_vertices->emissive);
  }

  void readVeil(const tinygltf::Material& source, double opacity, Material* material, GltfLooks::OfVertices* of_vertices) const {
    const tinygltf::Value* transmission = extensionOf(source.extensions, "KHR_materials_transmission");
    if (transmission != nullptr)
      material->transmission = checkedFactor(numberIn(*transmission, "transmissionFactor", 0.0), 1.0, "transmissionFactor");
    const bool is_cut = source.alphaMode == "MASK";
    if (!is_cut && source.alphaMode != "BLEND" && material->transmission == 0.0f) return;
    material->veil = Veil::thin;  // what it is in truth is judged once the scene is there
    if (!is_cut && source.alphaMode != "BLEND") return;
    of_vertices->keeps_opacity = true;
    const double factor = checkedFactor(opacity, 1.0, "baseColorFactor[3]");
    material->opacity = static_cast<float>(factor);
    if (!is_cut) return;
    const double cutoff = source.alphaCutoff;
    if (!(cutoff >= 0.0)) fail("alphaCutoff", "a number of 0 or more", std::to_string(cutoff));
    material->opacity = factor >= cutoff ? 1.0f : 0.0f;
    // above 1: nothing reaches the cutoff
    of_vertices->least_opacity = static_cast<float>(cutoff <= 0.0 ? 0.0 : factor > 0.0 ? std::min(cutoff / factor, 2.0) : 2.0);
  }

  // The least code whose share of 255 is no less. The tolerance is for cutoffs that an exporter computed in float.
  static int leastCode(float least_share) {
    return std::min(256, static_cast<int>(std::ceil(255.0 * static_cast<double>(least_share) - 1e-4)));
  }

  void readTransmissionImage(const tinygltf::Material& source, Material* material, GltfLooks::OfVertices* of_vertices) {
    const tinygltf::Value* transmission = extensionOf(source.extensions, "KHR_materials_transmission");
    if (transmission == nullptr || material->transmission == 0.0f || !transmission->Has("transmissionTexture")) return;
    const TextureInfo info = infoIn(*transmission, "transmissionTexture");
    GltfPlacing placing = of_vertices->base;
    use(info, {KeptAs::Colour::data, KeptAs::Opacity::none, 0, {}}, &material->transmission_image, &placing);
    const bool is_alone = of_vertices->base.set < 0;
    if (is_alone) of_vertices->base = placing;
    // a place for each image would be one more for every vertex of the scene: its mean will do
    if (!is_alone && placing != of_vertices->base) averaged_.insert(looks_.materials.size());
  }

  std::vector<double> fourIn(const tinygltf::Value& object, const char* key) const {
    const tinygltf::Value& four = object.Get(key);
    std::vector<double> numbers;
    for (size_t i = 0; four.IsArray() && i < four.ArrayLen(); ++i)
      numbers.push_back(four.Get(static_cast<int>(i)).IsNumber() ? four.Get(static_cast<int>(i)).GetNumberAsDouble() : -1.0);
    if (numbers.size() != 4) fail(key, "four numbers", "something else");
    return numbers;
  }

  TextureInfo infoOf(const tinygltf::TextureInfo& source, const char* key) const {
    TextureInfo info{place_ + ": " + key, source.index, {}};
    info.placing.set = source.texCoord;
    transform(extensionOf(source.extensions, "KHR_texture_transform"), &info);
    return info;
  }

  // The same of one that stands in an extension.
  TextureInfo infoIn(const tinygltf::Value& object, const char* key) const {
    const tinygltf::Value& source = object.Get(key);
    if (!source.IsObject()) fail(key, "an object", "something else");
    TextureInfo info{place_ + ": " + key, indexIn(source, "index", -1), {}};
    info.placing.set = indexIn(source, "texCoord", 0);
    const bool has_extensions = source.Has("extensions") && source.Get("extensions").IsObject();
    const bool has_transform = has_extensions && source.Get("extensions").Has("KHR_texture_transform");
    if (has_transform) transform(&source.Get("extensions").Get("KHR_texture_transform"), &info);
    return info;
  }

  void transform(const tinygltf::Value* source, TextureInfo* info) const {
    if (source == nullptr || !source->IsObject()) return;
    const glm::dvec2 offset = pairIn(*source, "offset", glm::dvec2(0.0)), scale = pairIn(*source, "scale", glm::dvec2(1.0));
    const double rotation = numberIn(*source, "rotation", 0.0), c = std::cos(rotation), s = std::sin(rotation);
    for (const double number : {offset.x, offset.y, scale.x, scale.y, rotation}) {
      if (!(std::abs(number) <= 1e6)) fail("KHR_texture_transform", "numbers of -1e6 to 1e6", std::to_string(number));
    }
    // counter-clockwise as the image is seen, whose v points down
    info->placing.from_mesh = glm::dmat3x2(glm::dvec2(c, -s) * scale.x, glm::dvec2(s, c) * scale.y, offset);
    info->placing.set = indexIn(*source, "texCoord", info->placing.set);
  }

  // Asks for the texture's image, and says where it lies on the mesh.
  void use(const TextureInfo& info, const KeptAs& kept, TextureUse* use, GltfPlacing* placing) {
    if (info.texture < 0) return;
    requireIndex(info.texture, model_.textures.size(), path_, info.place, "a texture");
    const tinygltf::Texture& texture = model_.textures[static_cast<size_t>(info.texture)];
    const int source = sourceOf(texture, info.texture);
    requireIndex(source, model_.images.size(), path_, fmt::format("textures[{}]: source", info.texture), "an image");
    if (!(info.placing.set >= 0 && info.placing.set < kMostSets))
      throw InputError(path_, info.place, fmt::format("a texCoord of 0 to {}", kMostSets - 1), std::to_string(info.placing.set));
    *placing = info.placing;
    use->image = loader_.want(images_.name(static_cast<size_t>(source)), kept);
    if (texture.sampler < 0) return;
    requireIndex(texture.sampler, model_.samplers.size(), path_, fmt::format("textures[{}]: sampler", info.texture), "a sampler");
    const tinygltf::Sampler& sampler = model_.samplers[static_cast<size_t>(texture.sampler)];
    use->wrap_u = wrapOf(sampler.wrapS);
    use->wrap_v = wrapOf(sampler.wrapT);
  }

  // Of several kinds the one that is read.
  int sourceOf(const tinygltf::Texture& texture, int idx) const {
    if (const tinygltf::Value* webp = extensionOf(texture.extensions, kImageExtensions[0])) return indexIn(*webp, "source", -1);
    if (texture.source >= 0) return texture.source;
    for (const char* name : kImageExtensions) {
      const tinygltf::Value* other = extensionOf(texture.extensions, name);
      if (other != nullptr) return indexIn(*other, "source", -1);
    }
    throw InputError(path_, fmt::format("textures[{}]", idx), "a source", "none");
  }

  static TextureWrap wrapOf(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::clamp;
    return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? TextureWrap::mirror : TextureWrap::repeat;
  }

  void loadImages() {
    if (loader_.wantsNone()) return;
    LoadedImages loaded = loader_.load([&](const std::string& name) { return images_.open(name); }, budgets_.pixels, path_);
    for (size_t i = 0; i < looks_.materials.size(); ++i) {
      Material& material = looks_.materials[i];
      if (!loaded.take(&material.base_image)) material.base_color *= kUnreadGrey;
      if (!loaded.take(&material.emissive_image)) material.emissive = glm::vec3(0.0f);
      if (!loaded.take(&material.transmission_image)) material.transmission *= kUnreadGrey;
      if (averaged_.count(i) > 0 && material.transmission_image.isThere()) {
        const auto image = static_cast<size_t>(std::exchange(material.transmission_image, {}).image);
        material.transmission *= meanRed(loaded.images[image]);
      }
      looks_.has_base_places |= material.base_image.isThere() || material.transmission_image.isThere();
      looks_.has_emissive_places |= material.emissive_image.isThere();
    }
    looks_.images = std::move(loaded.images);
    for (std::string& note : unreadImageNotes(loaded)) notes_->push_back(std::move(note));
  }

  static float meanRed(const TextureImage& image) {
    double sum = 0.0;
    for (const auto& texel : image.texels) sum += linearFromSrgb(texel[0]);
    return static_cast<float>(sum / static_cast<double>(image.texels.size()));
  }

  const std::string& path_;
  const tinygltf::Model& model_;
  SceneBudgets& budgets_;
  std::vector<std::string>* notes_;
  GltfImages images_;
  ImageLoader loader_;
  std::set<size_t> averaged_;  // materials whose transmission is the mean of its image
  GltfLooks looks_;
  std::string place_;
};

}  // namespace

GltfLooks readGltfLooks(const std::string& path, const tinygltf::Model& model, SceneBudgets& budgets,
                        std::vector<std::string>* notes, ImageNeed need) {
  return LooksReader(path, model, budgets, notes, need).read();
}

}  // namespace nlg
