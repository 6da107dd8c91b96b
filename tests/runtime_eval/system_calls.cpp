#include "tests/runtime_eval/system_calls.h"

#include <cstdlib>

namespace nlg {

void* alignedMemory(std::size_t size, std::size_t alignment) {
  // std::aligned_alloc takes multiples only
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size) != 0) std::abort();
  return memory;
}

void freeAlignedMemory(void* memory) { std::free(memory); }

void setEnvironment(const char* name, const char* value) { ::setenv(name, value, 1); }

}  // namespace nlg
