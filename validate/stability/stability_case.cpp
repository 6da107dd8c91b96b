#include "validate/stability/stability_case.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nlg {

void StabilityFigures::show(const std::string& key, double value) { add(key, value, true, ""); }

void StabilityFigures::atMost(const std::string& key, double value, double bound) {
  add(key, value, value <= bound, fmt::format("at most {:.4g}", bound));
}

void StabilityFigures::atLeast(const std::string& key, double value, double bound) {
  add(key, value, value >= bound, fmt::format("at least {:.4g}", bound));
}

void StabilityFigures::equals(const std::string& key, double value, double wanted) {
  add(key, value, value == wanted, fmt::format("exactly {:.10g}", wanted));
}

void StabilityFigures::require(bool holds, const std::string& claim) {
  constexpr int kNamed = 8;  // of many that break alike a table shows the first
  if (holds) return;
  holds_ = false;
  if (++broken_count_ <= kNamed) say("broken: " + claim);
}

void StabilityFigures::remark(const std::string& text) { say(text); }

void StabilityFigures::add(const std::string& key, double value, bool holds, const std::string& bound) {
  holds_ = holds_ && holds;
  figures_[key] = std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  std::string words = key;
  std::replace(words.begin(), words.end(), '_', ' ');
  const bool is_count = value == std::floor(value) && std::fabs(value) < 1e9;
  say(words + (is_count ? fmt::format(" {:.0f}", value) : fmt::format(" {:.4g}", value)) +
      (bound.empty() ? ""
       : holds       ? " (" + bound + ")"
                     : " (NOT " + bound + ")"));
}

void StabilityFigures::say(const std::string& text) { measured_ += (measured_.empty() ? "" : "; ") + text; }

}  // namespace nlg
