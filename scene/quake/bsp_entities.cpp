#include "scene/quake/bsp_entities.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scene/quake/bsp_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

bool isSpace(char c) { return static_cast<unsigned char>(c) <= ' '; }

constexpr size_t kMaxEntities = size_t{1} << 16;

// Reads a number from the text's start. returns   how many characters it took; 0 when none is there or it is too large
size_t readNumber(std::string_view text, double* value) {
  const size_t sign = text.starts_with('+') ? 1 : 0;
  const auto [end, error] = std::from_chars(text.data() + sign, text.data() + text.size(), *value);
  return error != std::errc() || !(std::abs(*value) <= kFarthestUnits) ? 0 : static_cast<size_t>(end - text.data());
}

}  // namespace

void QuakeTokens::skipSpace(bool stays_on_line) {
  while (at_ < text_.size()) {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("//")) {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (rest.starts_with("/*")) {
      const size_t end = text_.find("*/", at_ + 2);
      at_ = end == std::string_view::npos ? text_.size() : end + 2;
    } else if (isSpace(rest[0]) && !(stays_on_line && rest[0] == '\n')) {
      ++at_;
    } else {
      return;
    }
  }
}

bool QuakeTokens::next(std::string_view* word) {
  skipSpace(false);
  if (at_ >= text_.size()) return false;
  if (text_[at_] == '"') {
    const size_t end = std::min(text_.find('"', at_ + 1), text_.size());
    *word = text_.substr(at_ + 1, end - at_ - 1);
    at_ = std::min(end + 1, text_.size());
    return true;
  }
  const size_t start = at_++;
  if (text_[start] != '{' && text_[start] != '}') {
    while (at_ < text_.size() && !isSpace(text_[at_]) && text_[at_] != '"' && text_[at_] != '{' && text_[at_] != '}') {
      ++at_;
    }
  }
  *word = text_.substr(start, at_ - start);
  return true;
}

bool QuakeTokens::nextOnLine(std::string_view* word) {
  skipSpace(true);
  if (at_ >= text_.size() || text_[at_] == '\n') return false;
  return next(word);
}

std::string_view textOf(const BspEntity& entity, std::string_view key) {
  const auto found = entity.find(key);
  return found == entity.end() ? std::string_view() : found->second;
}

std::optional<glm::dvec3> threeNumbers(std::string_view text) {
  QuakeTokens words(text);
  glm::dvec3 numbers;
  for (int axis = 0; axis < 3; ++axis) {
    std::string_view word;
    if (!words.next(&word) || word.empty() || readNumber(word, &numbers[axis]) != word.size()) return std::nullopt;
  }
  return numbers;
}

std::optional<double> leadingNumber(std::string_view text) {
  double value = 0.0;
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  if (readNumber(text, &value) == 0) return std::nullopt;
  return value;
}

std::vector<BspEntity> readEntities(const std::string& path, std::string_view text) {
  std::vector<BspEntity> entities;
  QuakeTokens tokens(text.substr(0, text.find('\0')));
  std::string_view word;
  while (tokens.next(&word)) {
    const std::string place = "entity " + std::to_string(entities.size());
    if (entities.size() >= kMaxEntities) throw InputError(path, place, "at most 65536 entities", "more");
    if (word != "{") throw InputError(path, place, "an opening brace", std::string(word.substr(0, 40)));
    BspEntity entity;
    while (tokens.next(&word) && word != "}") {
      const std::string_view key = word;
      if (!tokens.next(&word)) break;
      entity[key] = word;
    }
    entities.push_back(std::move(entity));
  }
  return entities;
}

std::vector<BspStart> playerStarts(const std::vector<BspEntity>& entities) {
  std::vector<BspStart> starts;
  std::map<std::string, int> counts;
  for (const BspEntity& entity : entities) {
    const std::string classname(textOf(entity, "classname"));
    if (classname != "info_player_deathmatch" && classname != "info_player_start" && classname != "team_CTF_redspawn" &&
        classname != "team_CTF_bluespawn")
      continue;
    const std::optional<glm::dvec3> origin = threeNumbers(textOf(entity, "origin"));
    if (!origin) continue;
    const double turn = leadingNumber(textOf(entity, "angle")).value_or(0.0);
    starts.push_back({classname + " " + std::to_string(counts[classname]++), *origin, turn});
  }
  return starts;
}

std::vector<BspPlacement> readPlacements(const std::string& path, const std::vector<BspEntity>& entities, size_t model_count) {
  std::vector<BspPlacement> placements(model_count);
  std::vector<char> is_placed(model_count, 0);
  for (size_t i = 0; i < entities.size(); ++i) {
    const std::string place = "entity " + std::to_string(i);
    const std::string_view model = textOf(entities[i], "model"), origin = textOf(entities[i], "origin");
    // a brush model is named *N; model 0 is the world, which no entity names
    if (!model.starts_with('*')) continue;
    size_t idx = 0;
    const auto [end, error] = std::from_chars(model.data() + 1, model.data() + model.size(), idx);
    if (error != std::errc() || end != model.data() + model.size() || idx < 1 || idx >= model_count)
      throw InputError(path, place + ": model", "one of *1 to *" + std::to_string(model_count - 1),
                       std::string(model.substr(0, 40)));
    // of several entities with one model the first places it
    if (is_placed[idx]) continue;
    is_placed[idx] = 1;
    placements[idx].classname = std::string(textOf(entities[i], "classname").substr(0, 80));
    // without the key origin a model stands where its vertices are; the key shifts it, in Quake's units
    if (origin.empty()) continue;
    const std::optional<glm::dvec3> origin_units = threeNumbers(origin);
    if (!origin_units)
      throw InputError(path, place + ": origin", "three numbers within 1048576", std::string(origin.substr(0, 40)));
    placements[idx].origin_units = *origin_units;
  }
  return placements;
}

}  // namespace nlg
