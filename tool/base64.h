// Encodes and decodes base64.
#pragma once

#include <string>
#include <string_view>

namespace nlg {

// RFC 4648, with '=' to a multiple of four characters.
std::string base64(std::string_view bytes);

// false where the text is none that base64 gives
bool fromBase64(std::string_view text, std::string* bytes);

}  // namespace nlg
