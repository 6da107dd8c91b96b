#include "scene/scene_budget.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace nlg {

void SceneBudget::require(uint64_t amount, const std::string& path, const std::string& place) const {
  if (amount <= left()) return;
  const uint64_t room = std::numeric_limits<uint64_t>::max() - taken_;
  throw BudgetError(path, place, fmt::format("at most {} {} in one scene", most_, what_),
                    std::to_string(taken_ + std::min(amount, room)));
}

void SceneBudget::take(uint64_t amount, const std::string& path, const std::string& place) {
  require(amount, path, place);
  taken_ += amount;
}

std::string sceneBudgets() {
  return fmt::format(
      "Limits of one scene. glTF or .obj file: {} triangles, {} bytes of files and of what they unpack to,\n"
      "{} elements of glTF accessors, {} of these without a buffer view. Quake III level: {} triangles.\n"
      "Archives: {} bytes unpacked. Textures: {} pixels, times their scans. A scene beyond them is refused;\n"
      "no known level comes near (docs/guide/scenes.md).",
      kMaxSceneTriangles, kMaxSceneBytes, kMaxAccessorElements, kMaxAccessorZeros, kMaxLevelTriangles, kMaxUnpackedBytes,
      kMaxImagePixels);
}

}  // namespace nlg
