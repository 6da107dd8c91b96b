#include "viewer/data_script.h"

#include <bit>

namespace nlg {

static_assert(std::endian::native == std::endian::little, "arrays of a page are little-endian");

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t digit = 0; digit < 4; ++digit) {
      const bool is_padding = i + digit > bytes.size();
      text.push_back(is_padding ? '=' : kDigits[three >> (18 - 6 * digit) & 63]);
    }
  }
  return text;
}

std::string DataScript::text() const {
  nlohmann::ordered_json all = facts;
  all["arrays"] = arrays_;
  // no name of a scene may break its encoding
  const std::string json = all.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return "nlgReceive(\"" + name_ + "\", " + json + ", \"" + base64(bytes_) + "\");\n";
}

}  // namespace nlg
