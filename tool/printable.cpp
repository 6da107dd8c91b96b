#include "tool/printable.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace nlg {
namespace {

// kept   control characters that stay
std::string withoutControls(std::string_view text, std::string_view kept) {
  std::string shown;
  shown.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0u;
    const bool is_control = (byte < 0x20 || byte == 0x7f) && kept.find(text[i]) == std::string_view::npos;
    // U+0080 to U+009F: what ESC and a letter say, in one character
    const bool is_long_control = byte == 0xc2 && next >= 0x80 && next < 0xa0;
    shown += is_control || is_long_control ? ' ' : text[i];
    i += is_long_control ? 1 : 0;
  }
  return shown;
}

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

std::string printable(std::string_view text) {
  using Json = nlohmann::json;
  const std::string utf8 = Json(withoutControls(text, "")).dump(-1, ' ', false, Json::error_handler_t::replace);
  return Json::parse(utf8).get<std::string>();
}

PrintableBuffer::int_type PrintableBuffer::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(character);
  const char one = traits_type::to_char_type(character);
  return xsputn(&one, 1) == 1 ? character : traits_type::eof();
}

std::streamsize PrintableBuffer::xsputn(const char* text, std::streamsize count) {
  const std::string shown = withoutControls({text, static_cast<size_t>(count)}, "\n\t");
  const auto size = static_cast<std::streamsize>(shown.size());
  return behind_->sputn(shown.data(), size) == size ? count : 0;
}

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

std::optional<std::string> nearestName(const std::string& name, const std::vector<std::string>& known) {
  const auto distance = [&](const std::string& other) { return editDistance(name, other); };
  const auto nearest =
      std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (nearest == known.end() || distance(*nearest) > std::max<size_t>(1, nearest->size() / 3)) return std::nullopt;
  return *nearest;
}

}  // namespace nlg
