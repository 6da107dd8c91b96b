#include "datagen/dataset/duplicate_rule.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>

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

// Bits set in what `combine` makes of two rows of validity, 64 at a time: most pairs are told apart here, and without an instruction
// for it a popcount is a call.
template <class Combine>
uint64_t countBits(const uint8_t* a, const uint8_t* b, int byte_count, const Combine& combine) {
  uint64_t count = 0;
  for (int i = 0; i < byte_count; i += 8) {
    uint64_t words[2] = {};
    const size_t bytes = static_cast<size_t>(std::min(8, byte_count - i));
    std::memcpy(&words[0], a + i, bytes);
    std::memcpy(&words[1], b + i, bytes);
    if (const uint64_t bits = combine(words[0], words[1]); bits != 0) count += static_cast<uint64_t>(std::popcount(bits));
  }
  return count;
}

}  // namespace

std::optional<double> duplicateDistance(const DuplicateRule& rule, const StoredFunction& a, const StoredFunction& b,
                                        int point_count) {
  const int bytes = point_count / 8;
  if (countBits(a.validity, b.validity, bytes, std::bit_xor<uint64_t>()) > rule.validity_points) return std::nullopt;
  const uint64_t valid_in_both = countBits(a.validity, b.validity, bytes, std::bit_and<uint64_t>());
  const double limit = rule.rms * rule.rms * static_cast<double>(valid_in_both);
  uint64_t sum = 0;
  for (int i = 0; i < point_count; i += kBlock) {
    sum += squaredDifference(a.phi + i, b.phi + i, std::min(kBlock, point_count - i));
    if (static_cast<double>(sum) > limit) return std::nullopt;
  }
  return valid_in_both == 0 ? 0.0 : std::sqrt(static_cast<double>(sum) / static_cast<double>(valid_in_both));
}

}  // namespace nlg
