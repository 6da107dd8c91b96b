#include "tests/runtime_eval/counting_new.h"

#include <cstddef>
#include <new>

#include "tests/runtime_eval/system_calls.h"

namespace {

thread_local long allocations = 0;

void* allocate(std::size_t size, std::size_t alignment) {
  ++allocations;
  return nlg::alignedMemory(size, alignment);
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new[](std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) { return allocate(size, static_cast<std::size_t>(alignment)); }
void* operator new[](std::size_t size, std::align_val_t alignment) { return allocate(size, static_cast<std::size_t>(alignment)); }
// a sanitizer's own would take from its heap what is freed below
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, alignof(std::max_align_t)); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, alignof(std::max_align_t)); }
void operator delete(void* memory) noexcept { nlg::freeAlignedMemory(memory); }
void operator delete[](void* memory) noexcept { nlg::freeAlignedMemory(memory); }
void operator delete(void* memory, std::size_t) noexcept { nlg::freeAlignedMemory(memory); }
void operator delete[](void* memory, std::size_t) noexcept { nlg::freeAlignedMemory(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { nlg::freeAlignedMemory(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { nlg::freeAlignedMemory(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { nlg::freeAlignedMemory(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { nlg::freeAlignedMemory(memory); }

namespace nlg {

long allocationCount() { return allocations; }

}  // namespace nlg
