#include "tool/quantity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nlg {

std::string countText(uint64_t count) {
  std::string digits = std::to_string(count);
  for (size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

std::string countText(uint64_t count, const std::string& noun) { return countText(count) + " " + noun + (count == 1 ? "" : "s"); }

std::string roughCountText(double count, const std::string& noun) {
  return countText(static_cast<uint64_t>(std::stod(fmt::format("{:.2g}", std::clamp(count, 0.0, 1e18)))), noun);
}

std::string bytesText(double bytes) {
  if (bytes < 1e6) return fmt::format("{:.0f} kB", 1e-3 * bytes);
  return bytes < 1e9 ? fmt::format("{:.1f} MB", 1e-6 * bytes) : fmt::format("{:.1f} GB", 1e-9 * bytes);
}

std::string durationText(double seconds) {
  if (seconds < 9.95) return fmt::format("{:.1f} s", std::max(seconds, 0.0));
  const auto whole = std::lround(std::min(seconds, 1e9));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

}  // namespace nlg
