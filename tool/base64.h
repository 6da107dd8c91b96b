// Encodes and decodes base64.
#pragma once

#include <string>
#include <string_view>

namespace nlg {

// RFC 4648, with '=' to a multiple of four characters.
std::string base64(std::string_view bytes);

// Of either alphabet of RFC 4648 (+/ or -_), with or without '=' at the end, with white space anywhere. False where the text is none of these.
bool fromBase64(std::string_view text, std::string* bytes);

}  // namespace nlg
