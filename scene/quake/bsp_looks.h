// Reads the looks of a level's faces: shader scripts and images of its archives.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "scene/archive/pk3_archive.h"
#include "scene/archive/scene_file.h"
#include "scene/image/image_loader.h"
#include "scene/model/scene_light.h"
#include "scene/quake/bsp_shader.h"

namespace nlg {

// Means over all pixels of an sRGB image, each channel in [0, 1]: for skies, and for lights that name an image.
struct ImageMeans {
  glm::vec3 linear{0.0f};  // in linear light
  glm::vec3 code{0.0f};    // of the codes themselves, over 255: what Quake III's compilers take for the colour of a light
};

// pixels        its pixels are taken from this, as decodeImage does
// path, place   of the image, for errors
// returns       nothing for an image that decodeImage does not decode
// throws        InputError on more pixels, times scans, than the budget holds: as soon as that many would be decoded
std::optional<ImageMeans> imageMeans(std::string_view bytes, SceneBudget& pixels, const std::string& path,
                                     const std::string& place);

class BspLooks {
 public:
  // Reads the shader scripts. The archives must outlive this object.
  // throws   what readShaderScripts refuses. All that looks at images throws on more pixels than one scene may have.
  explicit BspLooks(const Pk3Archives& archives, ImageNeed need = ImageNeed::all);

  // Null when no script names the shader.
  const ShaderScript* scriptOf(const std::string& shader) const;
  // The average colour of the shader's texture, linear; nothing when no image of its is in the archives, or all are damaged.
  std::optional<glm::vec3> textureColour(const std::string& shader) const;
  // The archives' images that a face of the shader may show, the best first, and what is kept of them: of a script that cuts one out,
  // that one.
  std::vector<std::string> images(const std::string& shader) const;
  KeptAs keptAs(const std::string& shader) const;
  LoadedImages load(const ImageLoader& images) const;
  ImageNeed need() const { return need_; }
  // A page of light in a file of that name, without suffix; nothing where there is none, or it is damaged.
  std::optional<DecodedImage> page(const std::string& name) const;
  // Radiance of a face: q3map_surfacelight in the light's own colour; 0 for one that does not shine.
  glm::vec3 emission(const std::string& shader) const;
  // Radiance of a sky: what the level's compiler took it for (q3map_surfacelight, q3map_skylight), otherwise what its images look
  // like; dark when it has none.
  Sky sky(const std::string& shader) const;

 private:
  // Of the first image of that name, without suffix, that is not damaged.
  std::optional<ImageMeans> image(const std::string& name) const;
  const std::optional<ImageMeans>& entryMeans(const std::string& entry) const;
  std::vector<std::string> textureNames(const std::string& shader) const;
  glm::vec3 lightHue(const std::string& shader, const ScriptLight& light) const;
  std::optional<Sky> skyBox(const std::string& stem) const;

  const Pk3Archives& archives_;
  const ImageNeed need_;
  ShaderScripts scripts_;
  // many shaders may share an image: each is decoded once
  mutable std::map<std::string, std::optional<ImageMeans>> images_;  // by entry
  mutable SceneBudget pixels_left_ = SceneBudgets().pixels;
};

}  // namespace nlg
