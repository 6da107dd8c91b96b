// Switches subnormal numbers off, with which some processors are up to a hundred times as slow.
#pragma once

#include <cstdint>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace nlg {

// While one lives, its thread takes numbers below 2^-126 for 0, as operands and as results; afterwards all is as it was. Derivatives of
// sigmoids far from their middle are such numbers, and those of units that hardly count. On processors other than x86 and AArch64 it
// does nothing.
class FlushSubnormals {
 public:
  FlushSubnormals() : before_(control()) { setControl(before_ | kFlush); }
  ~FlushSubnormals() { setControl(before_); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
#if defined(__SSE__)
  using Control = uint32_t;
  static constexpr Control kFlush = 0x8040;  // of results, and of operands
  static Control control() { return _mm_getcsr(); }
  static void setControl(Control value) { _mm_setcsr(value); }
#elif defined(__aarch64__)
  using Control = uint64_t;
  static constexpr Control kFlush = uint64_t{1} << 24;
  static Control control() {
    Control value;
    asm volatile("mrs %0, fpcr" : "=r"(value));
    return value;
  }
  static void setControl(Control value) { asm volatile("msr fpcr, %0" : : "r"(value)); }
#else
  using Control = uint32_t;
  static constexpr Control kFlush = 0;
  static Control control() { return 0; }
  static void setControl(Control) {}
#endif

  Control before_;
};

}  // namespace nlg
