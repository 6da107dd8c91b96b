#include "export/engine/godot_format.h"

#include <array>
#include <cstdio>

#include "export/engine/sh_texture.h"
#include "tool/base64.h"
#include "tool/error.h"

namespace nlg {
namespace {

const std::string kTexture = "light.tres", kShader = "light.gdshaderinc";
constexpr std::string_view kBeforeBytes = "\"data\": PackedByteArray(\"", kAfterBytes = "\"),\n";

// What follows an image's bytes.
std::string imageShape(const TextureSize& size) {
  return "\"format\": \"RGBAHalf\",\n\"height\": " + std::to_string(size[1]) +
         ",\n\"mipmaps\": false,\n\"width\": " + std::to_string(size[0]) + "\n}\n\n";
}

std::string textureText(const TextureSize& size, std::string_view texels) {
  const size_t slice = texels.size() / size[2];
  std::string text = "[gd_resource type=\"ImageTexture3D\" load_steps=" + std::to_string(size[2] + 1) + " format=4]\n\n", images;
  for (size_t z = 0; z < size[2]; ++z) {
    const std::string name = "Image_" + std::to_string(z);
    text += "[sub_resource type=\"Image\" id=\"" + name + "\"]\ndata = {\n";
    text.append(kBeforeBytes).append(base64(texels.substr(z * slice, slice))).append(kAfterBytes).append(imageShape(size));
    images += (z > 0 ? ", " : "") + ("SubResource(\"" + name + "\")");
  }
  return text + "[resource]\n_images = Array[Image]([" + images + "])\n";
}

// With a point: shaders take other numbers for integers.
std::string shaderNumber(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", number);
  const std::string written = text;
  return written.find_first_of(".e") == std::string::npos ? written + ".0" : written;
}

template <class Three>
std::string vec3(const Three& three) {
  return "vec3(" + shaderNumber(three[0]) + ", " + shaderNumber(three[1]) + ", " + shaderNumber(three[2]) + ")";
}

std::string shaderText(const LightBox& box) {
  std::string text = "// Made by nlg-export engine for one grid: light.tres, beside this file.\n";
  text += "uniform sampler3D nlg_light : filter_linear, repeat_disable;\n";
  text += "const vec3 NLG_LOW_M = " + vec3(box.low_m) + ";\nconst vec3 NLG_HIGH_M = " + vec3(box.high_m) + ";\n";
  text += "const vec3 NLG_RESOLUTION = " + vec3(box.texel_count) + ";\n\n";
  return text.append(kGodotShaderText);
}

}  // namespace

std::vector<EngineFile> godotFiles(const LightVolume& volume) {
  return {{kTexture, textureText(shTextureSize(volume.box.texel_count), packShTexture(volume))},
          {kShader, shaderText(volume.box)}};
}

EngineIrradiance readGodot(const std::vector<EngineFile>& files, const LightBox& box) {
  const std::string& text = fileNamed(files, kTexture);
  const TextureSize size = shTextureSize(box.texel_count);
  const std::string shape = imageShape(size);
  std::string texels, slice;
  size_t end = 0;
  for (uint32_t z = 0; z < size[2]; ++z) {
    const std::string place = "image " + std::to_string(z);
    const size_t begin = text.find(kBeforeBytes, end);
    if (begin == std::string::npos) throw InputError(kTexture, place, std::to_string(size[2]) + " images", "no more of them");
    const size_t first = begin + kBeforeBytes.size();
    end = text.find(kAfterBytes, first);
    if (end == std::string::npos || !fromBase64(std::string_view(text).substr(first, end - first), &slice) ||
        slice.size() != size_t{8} * size[0] * size[1] || text.compare(end + kAfterBytes.size(), shape.size(), shape) != 0)
      throw InputError(kTexture, place, "RGBAHalf in base64, of the box's size", "another");
    texels += slice;
  }
  return shTextureReader(textureOfHalves(texels, size), box);
}

}  // namespace nlg
