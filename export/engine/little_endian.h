// Numbers as little-endian bytes, and back: the same on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace nlg {

// byte_count   1 … 8, of the number's lowest bytes
inline void appendNumber(uint64_t number, size_t byte_count, std::string* bytes) {
  for (size_t i = 0; i < byte_count; ++i) bytes->push_back(static_cast<char>(number >> 8 * i & 0xff));
}

// place        place + byte_count <= bytes.size()
inline uint64_t numberAt(std::string_view bytes, size_t place, size_t byte_count) {
  uint64_t number = 0;
  for (size_t i = 0; i < byte_count; ++i) number |= uint64_t{static_cast<uint8_t>(bytes[place + i])} << 8 * i;
  return number;
}

}  // namespace nlg
