#include "tool/base64.h"

#include <cstdint>

namespace nlg {
namespace {

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::string base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = i; k < i + 3; ++k) bits = bits << 8 | (k < bytes.size() ? static_cast<uint8_t>(bytes[k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text.push_back(i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=');
  }
  return text;
}

bool fromBase64(std::string_view text, std::string* bytes) {
  bytes->clear();
  uint32_t bits = 0;
  size_t digits = 0, padding = 0;
  for (const char c : text) {
    if (std::string_view(" \t\r\n").find(c) != std::string_view::npos || (c == '=' && ++padding <= 2)) continue;
    const size_t digit = kDigits.find(c == '-' ? '+' : c == '_' ? '/' : c);
    if (digit == std::string_view::npos || padding > 0) return false;
    bits = bits << 6 | static_cast<uint32_t>(digit);
    // of four digits the second to the fourth end a byte
    if (++digits % 4 != 1) bytes->push_back(static_cast<char>(bits >> 2 * ((4 - digits % 4) % 4)));
  }
  return digits % 4 != 1;
}

}  // namespace nlg
