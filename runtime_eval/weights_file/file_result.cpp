#include "nlg/result.h"

#include <iterator>

namespace nlg {

const char* fileStatusName(FileStatus status) {
  constexpr const char* kNames[] = {
      "ok",
      "cannot_open",
      "cannot_read",
      "too_short",
      "header_too_large",
      "header_malformed",
      "tensor_malformed",
      "tensor_missing",
      "tensor_unexpected",
      "value_not_finite",
      "value_out_of_range",
      "version_unknown",
      "pattern_unknown",
      "simd_unavailable",
      "digest_mismatch",
  };
  static_assert(std::size(kNames) == static_cast<size_t>(FileStatus::digest_mismatch) + 1);
  // engines hand over any number
  const auto place = static_cast<size_t>(status);
  return place < std::size(kNames) ? kNames[place] : "unknown";
}

}  // namespace nlg
