#include "datagen/dataset/duplicate_rule.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace nlg {
namespace {

constexpr int kBlock = 512;  // points between two looks at whether the sum is too large already

uint32_t squaredDifference(const uint8_t* a, const uint8_t* b, int count) {
  uint32_t sum = 0;
  for (int i = 0; i < count; ++i) {
    const int difference = int{a[i]} - int{b[i]};
    sum += static_cast<uint32_t>(difference * difference);
  }
  return sum;
}

}  // namespace

std::optional<double> duplicateDistance(const DuplicateRule& rule, const StoredFunction& a, const StoredFunction& b,
                                        int point_count) {
  uint64_t differing = 0, valid_in_both = 0;
  for (int i = 0; i < point_count / 8; ++i) {
    differing += static_cast<uint64_t>(std::popcount(static_cast<uint8_t>(a.validity[i] ^ b.validity[i])));
    valid_in_both += static_cast<uint64_t>(std::popcount(static_cast<uint8_t>(a.validity[i] & b.validity[i])));
  }
  if (differing > rule.validity_points) return std::nullopt;
  const double limit = rule.rms * rule.rms * static_cast<double>(valid_in_both);
  uint64_t sum = 0;
  for (int i = 0; i < point_count; i += kBlock) {
    sum += squaredDifference(a.phi + i, b.phi + i, std::min(kBlock, point_count - i));
    if (static_cast<double>(sum) > limit) return std::nullopt;
  }
  return valid_in_both == 0 ? 0.0 : std::sqrt(static_cast<double>(sum) / static_cast<double>(valid_in_both));
}

}  // namespace nlg
