// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#materials and the extensions beside it
#include "scene/gltf/gltf_looks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "scene/archive/scene_file.h"
#include "scene/gltf/gltf_accessor.h"
#include "scene/gltf/gltf_json.h"
#include "scene/gltf/gltf_light.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

constexpr int kMostSets = 64;  // TEXCOORD_n
constexpr const char* kGrey = "half of the factor instead";

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
      const bool has_file = !image.uri.empty() && !isDataUri(image.uri);
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
      try {
        bytes.elsewhere = bytesOfView(model_, image.bufferView, path_, fmt::format("images[{}]: bufferView", idx));
      } catch (const InputError&) {
        bytes.problem = "has no bytes where the file says they are";
      }
    } else if (isDataUri(image.uri)) {
      std::string decoded;
      if (!dataOfUri(image.uri, &decoded)) bytes.problem = "has a data URI that is none of RFC 2397";
      bytes.own.assign(decoded.begin(), decoded.end());
    } else {
      bytes = imageBeside(path_, image.uri, bytes_left_);
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
              Oddities* odd, ImageNeed need)
      : path_(path),
        model_(model),
        budgets_(budgets),
        notes_(notes),
        odd_(*odd),
        images_(path, model, budgets.bytes),
        loader_(need) {}

  GltfLooks read() {
    const std::set<int> used = usedMaterials();
    for (size_t i = 0; i < model_.materials.size(); ++i) {
      const std::string& name = model_.materials[i].name;
      place_ = "material " + (name.empty() ? std::to_string(i) : name.substr(0, 60));
      looks_.names.push_back(name);
      looks_.materials.emplace_back();
      looks_.of_vertices.emplace_back();
      if (used.count(static_cast<int>(i)) > 0)
        readMaterial(model_.materials[i], &looks_.materials.back(), &looks_.of_vertices.back());
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

  float checkedFactor(double value, double limit, const std::string& what) {
    // the tolerance is for factors that an exporter computed in float
    if (!(value >= 0.0 && value <= limit * 1.001))
      odd_.add(fmt::format("brought into 0 to {:g}", limit), fmt::format("{}: {} of {:g}", place_, what, value));
    return static_cast<float>(std::clamp(value, 0.0, limit));
  }

  // A number in an extension; the text has not been held against a format there.
  double numberIn(const tinygltf::Value& object, const char* key, double fallback) const {
    if (!object.Has(key)) return fallback;
    if (!object.Get(key).IsNumber()) fail(key, "a number", "something else");
    return object.Get(key).GetNumberAsDouble();
  }

  // So many numbers; none where there is no such key.
  std::vector<double> numbersIn(const tinygltf::Value& object, const char* key, size_t count) const {
    const tinygltf::Value& array = object.Get(key);
    std::vector<double> numbers;
    for (size_t i = 0; array.IsArray() && i < array.ArrayLen(); ++i) {
      const tinygltf::Value& number = array.Get(static_cast<int>(i));
      if (number.IsNumber()) numbers.push_back(number.GetNumberAsDouble());
    }
    if (object.Has(key) && (numbers.size() != count || array.ArrayLen() != count))
      fail(key, fmt::format("{} numbers", count), "something else");
    return numbers;
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

  void readMaterial(const tinygltf::Material& source, Material* material, GltfLooks::OfVertices* of_vertices) {
    material->double_sided = source.doubleSided;
    std::vector<double> base = source.pbrMetallicRoughness.baseColorFactor;
    TextureInfo base_info;
    const bool is_read = odd_.attempt(kGrey, [&] {
      base_info = infoOf(source.pbrMetallicRoughness.baseColorTexture, "baseColorTexture");
      // what stands in the place of the rest in files from before 2019
      if (const tinygltf::Value* old = extensionOf(source.extensions, "KHR_materials_pbrSpecularGlossiness")) {
        if (old->Has("diffuseFactor")) base = numbersIn(*old, "diffuseFactor", 4);
        if (old->Has("diffuseTexture")) base_info = infoIn(*old, "diffuseTexture");
      }
    });
    for (int channel = 0; channel < 3; ++channel)
      material->base_color[channel] = checkedFactor(base[static_cast<size_t>(channel)], 1.0, "baseColorFactor");
    material->label = {source.name, lightGroupOf(source.extras)};
    if (!odd_.attempt("does not shine", [&] { readEmission(source, material, of_vertices); }))
      material->emissive = glm::vec3(0.0f);
    odd_.attempt("lets no light through", [&] { readTransmissive(source, base[3], material, of_vertices); });
    KeptAs kept;
    if (material->transmissive != Transmissive::none && source.alphaMode == "BLEND") kept.opacity = KeptAs::Opacity::mean;
    if (material->transmissive != Transmissive::none && source.alphaMode == "MASK") {
      kept.opacity = KeptAs::Opacity::cut;
      kept.least_code = leastCode(of_vertices->least_opacity);
      // cut at the texels, not at the factor
      if (base_info.texture >= 0) material->opacity = 1.0f;
    }
    if (!is_read || !odd_.attempt(kGrey, [&] { use(base_info, kept, &material->base_image, &of_vertices->base); }))
      material->base_color *= kUnreadGrey;
    if (!odd_.attempt(kGrey, [&] { readTransmissionImage(source, material, of_vertices); }))
      material->transmission *= kUnreadGrey;
  }

  void readEmission(const tinygltf::Material& source, Material* material, GltfLooks::OfVertices* of_vertices) {
    const tinygltf::Value* extension = extensionOf(source.extensions, "KHR_materials_emissive_strength");
    const double strength =
        extension == nullptr ? 1.0 : checkedFactor(numberIn(*extension, "emissiveStrength", 1.0), kBrightest, "emissiveStrength");
    const std::vector<double>& factor = source.emissiveFactor;
    const double most = *std::max_element(factor.begin(), factor.end());
    // programs write so what others write as a strength
    if (most > 1.001) odd_.add("taken as it is", fmt::format("{}: emissiveFactor of {:g}, above 1", place_, most));
    for (int channel = 0; channel < 3; ++channel)
      material->emissive[channel] = checkedFactor(
          strength * checkedFactor(factor[static_cast<size_t>(channel)], kBrightest, "emissiveFactor"), kBrightest, "emission");
    // it is drawn as it is, without light: neither its own
    if (extensionOf(source.extensions, "KHR_materials_unlit") != nullptr) material->emissive = glm::vec3(0.0f);
    if (material->emissive == glm::vec3(0.0f)) return;
    use(infoOf(source.emissiveTexture, "emissiveTexture"), {}, &material->emissive_image, &of_vertices->emissive);
  }

  void readTransmissive(const tinygltf::Material& source, double opacity, Material* material,
                        GltfLooks::OfVertices* of_vertices) {
    const tinygltf::Value* transmission = extensionOf(source.extensions, "KHR_materials_transmission");
    if (transmission != nullptr)
      material->transmission = checkedFactor(numberIn(*transmission, "transmissionFactor", 0.0), 1.0, "transmissionFactor");
    const bool is_cut = source.alphaMode == "MASK";
    if (!is_cut && source.alphaMode != "BLEND" && material->transmission == 0.0f) return;
    material->transmissive = Transmissive::thin;  // what it is in truth is judged once the scene is there
    if (!is_cut && source.alphaMode != "BLEND") return;
    of_vertices->keeps_opacity = true;
    const double factor = checkedFactor(opacity, 1.0, "baseColorFactor[3]");
    material->opacity = static_cast<float>(factor);
    if (!is_cut) return;
    const double cutoff = std::max(source.alphaCutoff, 0.0);
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
    if (!is_alone && placing != of_vertices->base) averaged_.insert(looks_.materials.size() - 1);
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
    const std::vector<double> offsets = numbersIn(*source, "offset", 2), scales = numbersIn(*source, "scale", 2);
    const glm::dvec2 offset = offsets.empty() ? glm::dvec2(0.0) : glm::dvec2(offsets[0], offsets[1]);
    const glm::dvec2 scale = scales.empty() ? glm::dvec2(1.0) : glm::dvec2(scales[0], scales[1]);
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
    odd_.attempt("repeated instead", [&] {
      requireIndex(texture.sampler, model_.samplers.size(), path_, fmt::format("textures[{}]: sampler", info.texture),
                   "a sampler");
      const tinygltf::Sampler& sampler = model_.samplers[static_cast<size_t>(texture.sampler)];
      use->wrap_u = wrapOf(sampler.wrapS);
      use->wrap_v = wrapOf(sampler.wrapT);
    });
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
  Oddities& odd_;
  GltfImages images_;
  ImageLoader loader_;
  std::set<size_t> averaged_;  // materials whose transmission is the mean of its image
  GltfLooks looks_;
  std::string place_;
};

}  // namespace

GltfLooks readGltfLooks(const std::string& path, const tinygltf::Model& model, SceneBudgets& budgets,
                        std::vector<std::string>* notes, Oddities* odd, ImageNeed need) {
  return LooksReader(path, model, budgets, notes, odd, need).read();
}

}  // namespace nlg
