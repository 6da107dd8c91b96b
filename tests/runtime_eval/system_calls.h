// What tests of the library ask of the operating system: system_calls.cpp asks POSIX, system_calls_windows.cpp Windows.
#pragma once

#include <cstddef>

namespace nlg {

// Exactly as many bytes as asked for, so that a sanitizer sees the first one beyond them; aborts where there are none.
void* alignedMemory(std::size_t size, std::size_t alignment);
// memory   may be null
void freeAlignedMemory(void* memory);

void setEnvironment(const char* name, const char* value);

}  // namespace nlg
