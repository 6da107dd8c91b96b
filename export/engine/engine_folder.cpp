#include "export/engine/engine_folder.h"

#include <filesystem>

#include "export/shader/shader_export.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/output_path.h"

namespace nlg {

nlohmann::ordered_json placeJson(const LightBox& box) {
  return {{"low_m", box.low_m},
          {"high_m", box.high_m},
          {"resolution", box.texel_count},
          {"texture_size", shTextureSize(box.texel_count)}};
}

void requireTexture(const LightBox& box) {
  const TextureSize size = shTextureSize(box.texel_count);
  for (size_t axis = 0; axis < 3; ++axis) {
    if (size[axis] <= kMaxTextureSide) continue;
    throw UsageError("spacing_m", "a texture of at most " + std::to_string(kMaxTextureSide) + " texels along each axis",
                     std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]));
  }
}

const TextureFormat* findTexture(const std::string& name) {
  for (const TextureFormat& format : textureFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

std::string textureNames() {
  std::string names;
  for (const TextureFormat& format : textureFormats()) names += std::string(format.name) + ", ";
  return names;
}

void writeEngineFolder(const std::string& folder, const EngineFile& record, const std::vector<EngineFile>& files,
                       const std::vector<std::string>& inputs) {
  namespace fs = std::filesystem;
  const auto pathOf = [&](const EngineFile& file) { return (fs::path(folder) / file.name).string(); };
  std::vector<EngineFile> all = files;
  const bool is_own = fs::exists(pathOf(record)) && mayReplace(pathOf(record), kExportedFiles);
  if (!record.bytes.empty()) all.push_back(record);
  for (const EngineFile& file : all) {
    refuseToReplaceInputs(pathOf(file), inputs);
    if (!is_own) refuseToReplaceOthers(pathOf(file), kExportedFiles);
  }
  for (const EngineFile& file : all) writeFileAtomically(pathOf(file), file.bytes);
}

}  // namespace nlg
