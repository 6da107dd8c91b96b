// The folder that a command of `nlg-export` fills with an engine's files.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "export/engine/engine_format.h"

namespace nlg {

// Where the texels of a texture lie.
nlohmann::ordered_json placeJson(const LightBox& box);

// throws   UsageError naming spacing_m where a side of its texture would be above kMaxTextureSide
void requireTexture(const LightBox& box);

// The texture of that name; null: none has it.
const TextureFormat* findTexture(const std::string& name);
// "three, ktx2-sh, "
std::string textureNames();

// Texels alone bear no name: where the record is that this tool wrote beside them, they are replaced, and nothing else is.
// record   the text that says what was written
// inputs   files that must not be among those to come
void writeEngineFolder(const std::string& folder, const EngineFile& record, const std::vector<EngineFile>& files,
                       const std::vector<std::string>& inputs);

}  // namespace nlg
