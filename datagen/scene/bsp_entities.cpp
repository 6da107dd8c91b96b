#include "datagen/scene/bsp_entities.h"

#include <charconv>
#include <cmath>

#include "datagen/scene/quake_tokens.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kMaxEntities = size_t{1} << 16;
constexpr double kFarthest = 1048576.0;

bool readOrigin(std::string_view text, glm::dvec3* origin) {
  QuakeTokens words(text);
  for (int axis = 0; axis < 3; ++axis) {
    std::string_view word;
    if (!words.next(&word)) return false;
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), (*origin)[axis]);
    if (error != std::errc() || end != word.data() + word.size() || !(std::abs((*origin)[axis]) <= kFarthest)) return false;
  }
  return true;
}

}  // namespace

std::vector<BspPlacement> readPlacements(const std::string& path, std::string_view entities, size_t model_count) {
  std::vector<BspPlacement> placements(model_count);
  std::vector<char> is_placed(model_count, 0);
  QuakeTokens tokens(entities.substr(0, entities.find('\0')));
  std::string_view word;
  for (size_t entity = 0; tokens.next(&word); ++entity) {
    const std::string place = "entity " + std::to_string(entity);
    if (entity >= kMaxEntities) throw InputError(path, place, "at most 65536 entities", "more");
    if (word != "{") throw InputError(path, place, "an opening brace", std::string(word.substr(0, 40)));
    std::string_view classname, model, origin;
    while (tokens.next(&word) && word != "}") {
      const std::string_view key = word;
      if (!tokens.next(&word)) break;
      if (key == "classname") classname = word;
      if (key == "model") model = word;
      if (key == "origin") origin = word;
    }
    if (!model.starts_with('*')) continue;
    size_t idx = 0;
    const auto [end, error] = std::from_chars(model.data() + 1, model.data() + model.size(), idx);
    if (error != std::errc() || end != model.data() + model.size() || idx < 1 || idx >= model_count)
      throw InputError(path, place + ": model", "one of *1 to *" + std::to_string(model_count - 1),
                       std::string(model.substr(0, 40)));
    if (is_placed[idx]) continue;
    is_placed[idx] = 1;
    placements[idx].classname = std::string(classname.substr(0, 80));
    if (!origin.empty() && !readOrigin(origin, &placements[idx].origin_units))
      throw InputError(path, place + ": origin", "three numbers within 1048576", std::string(origin.substr(0, 40)));
  }
  return placements;
}

}  // namespace nlg
