// A text as a field of a CSV file: file stems may hold commas.
#pragma once

#include <string>

namespace nlg {

inline std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

}  // namespace nlg
