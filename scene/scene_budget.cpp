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
      "One scene may take, of a glTF or .obj file: {} triangles, {} bytes of files and what they unpack to,\n"
      "{} elements of glTF accessors, {} of these without a buffer view; of a Quake III level: {} triangles;\n"
      "of archives: {} bytes unpacked; of textures: {} pixels, times their scans. No known level comes near\n"
      "(docs/guide/scenes.md); a scene that asks for more is refused.",
      kMaxSceneTriangles, kMaxSceneBytes, kMaxAccessorElements, kMaxAccessorZeros, kMaxLevelTriangles, kMaxUnpackedBytes,
      kMaxImagePixels);
}

}  // namespace nlg
