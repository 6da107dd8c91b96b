#include "datagen/scene/scene_source.h"

#include "datagen/scene/gltf_reader.h"
#include "datagen/scene/procedural.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {

SceneSource loadScene(const std::string& request) {
  SceneSource source;
  for (const std::string& family : proceduralFamilies()) {
    if (request.rfind(family + ":", 0) != 0) continue;
    const std::string number = request.substr(family.size() + 1);
    if (number.empty() || number.size() > 18 || number.find_first_not_of("0123456789") != std::string::npos) {
      throw UsageError("--scene", family + ":SEED with a decimal seed", "'" + request + "'");
    }
    source.family = family;
    source.id = family + "_" + number;
    source.scene = makeProceduralScene(family, std::stoull(number));
    return source;
  }
  source.scene = readGltf(request);
  source.id = source.scene.id;
  source.sha256 = fileSha256(request);
  return source;
}

}  // namespace nlg
