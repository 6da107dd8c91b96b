// Godot 4.3 and later: light.tres, an ImageTexture3D of sh_texture.h as a text resource, and light.gdshaderinc, which reads it in a
// shader that sets IRRADIANCE.
//
// A text resource of format 4: an Image a slice, RGBAHalf, its bytes in base64, and the texture's property _images
// (scene/resources/resource_format_text.h, scene/resources/image_texture.cpp of Godot).
#pragma once

#include <string_view>

#include "export/engine/engine_format.h"

namespace nlg {

extern const std::string_view kGodotShaderText;  // export/engine/light.gdshaderinc

std::vector<EngineFile> godotFiles(const LightVolume& volume);
EngineIrradiance readGodot(const std::vector<EngineFile>& files, const LightBox& box);

}  // namespace nlg
