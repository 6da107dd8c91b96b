#include <malloc.h>

#include <cstdlib>

#include "tests/runtime_eval/system_calls.h"

namespace nlg {

void* alignedMemory(std::size_t size, std::size_t alignment) {
  void* const memory = _aligned_malloc(size, alignment);
  if (memory == nullptr) std::abort();
  return memory;
}

void freeAlignedMemory(void* memory) { _aligned_free(memory); }

void setEnvironment(const char* name, const char* value) { _putenv_s(name, value); }

}  // namespace nlg
