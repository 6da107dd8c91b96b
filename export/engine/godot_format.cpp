#include "export/engine/godot_format.h"

#include <array>
#include <cstdio>

#include "export/engine/sh_texture.h"
#include "tool/error.h"

namespace nlg {
namespace {

const std::string kTexture = "light.tres", kShader = "light.gdshaderinc";
constexpr std::string_view kBeforeBytes = "\"data\": PackedByteArray(\"", kAfterBytes = "\"),\n";
constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

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

std::string base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = i; k < i + 3; ++k) bits = bits << 8 | (k < bytes.size() ? static_cast<uint8_t>(bytes[k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text.push_back(i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=');
  }
  return text;
}

bool fromBase64(std::string_view text, std::string* bytes) {
  bytes->clear();
  if (text.size() % 4 != 0) return false;
  size_t padding = 0;
  while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') ++padding;
  for (size_t i = 0; i < text.size(); i += 4) {
    uint32_t bits = 0;
    for (size_t k = i; k < i + 4; ++k) {
      const size_t digit = k < text.size() - padding ? kDigits.find(text[k]) : 0;
      if (digit == std::string_view::npos) return false;
      bits = bits << 6 | static_cast<uint32_t>(digit);
    }
    for (unsigned shift = 24; shift > 0; shift -= 8) bytes->push_back(static_cast<char>(bits >> (shift - 8) & 0xff));
  }
  bytes->resize(bytes->size() - padding);
  return true;
}

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
