#include "tool/nearest_name.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace nlg {
namespace {

// Levenshtein distance, one row at a time.
size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearestName(const std::string& name, const std::vector<std::string>& known) {
  const auto distance = [&](const std::string& other) { return editDistance(name, other); };
  const auto nearest =
      std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (nearest == known.end() || distance(*nearest) > std::max<size_t>(1, nearest->size() / 3)) return std::nullopt;
  return *nearest;
}

}  // namespace nlg
