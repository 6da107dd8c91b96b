#include "scene/model/oddities.h"

#include <algorithm>

#include <fmt/format.h>

namespace nlg {

std::vector<std::string> Oddities::notes() const {
  std::vector<std::string> notes;
  for (const auto& [how, parts] : parts_) {
    const size_t others = parts.size() - 1;
    const std::string more = others == 0 ? "" : others == 1 ? " and another one" : fmt::format(" and {} others", others);
    notes.push_back(fmt::format("{}{}: {}", parts[0], more, how));
  }
  return notes;
}

std::string counted(size_t count, const std::string& one, const std::string& many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string listed(const std::vector<std::string>& names) {
  constexpr size_t kMost = 6;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i > 0 ? ", " : "") + names[i].substr(0, 100);
  return names.size() > kMost ? fmt::format("{} and {} more", text, names.size() - kMost) : text;
}

}  // namespace nlg
