#include "nlg/simd.h"

#include <cstdint>
#include <cstdlib>

#include <hwy/highway.h>

namespace nlg {
namespace {

struct NamedTarget {
  std::string_view name;
  int64_t bit;  // 0: of another architecture
};

// Best first, as the bits are: a lower one is a better target. Which of the two scalar ones there is depends on the compiler.
constexpr int64_t kScalar = HWY_EMU128 | HWY_SCALAR;
#if HWY_ARCH_X86
constexpr NamedTarget kTargets[] = {{"avx512", HWY_AVX3}, {"avx2", HWY_AVX2}, {"sse4", HWY_SSE4},
                                    {"ssse3", HWY_SSSE3}, {"neon", 0},        {"scalar", kScalar}};
#elif HWY_ARCH_ARM
constexpr NamedTarget kTargets[] = {{"avx512", 0}, {"avx2", 0},        {"sse4", 0},
                                    {"ssse3", 0},  {"neon", HWY_NEON}, {"scalar", kScalar}};
#else
constexpr NamedTarget kTargets[] = {{"avx512", 0}, {"avx2", 0}, {"sse4", 0}, {"ssse3", 0}, {"neon", 0}, {"scalar", kScalar}};
#endif

// What the build has and the machine supports, whatever was forced meanwhile. What the compiler itself may use is always among it: Highway,
// where it was compiled to choose, asks for more.
int64_t machineTargets() {
  static const int64_t targets = (hwy::SupportedTargets() | HWY_STATIC_TARGET | kScalar) & HWY_TARGETS;
  return targets;
}

void restrictTo(int64_t targets) {
  hwy::SetSupportedTargetsForTest(targets);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace

std::vector<std::string_view> availableSimdTargets() {
  std::vector<std::string_view> names;
  for (const NamedTarget& target : kTargets) {
    if (machineTargets() & target.bit) names.push_back(target.name);
  }
  return names;
}

std::string_view chosenSimdTarget() {
  const int64_t allowed = machineTargets() & hwy::SupportedTargets();
  for (const NamedTarget& target : kTargets) {
    if (allowed & target.bit) return target.name;
  }
  return hwy::TargetName(allowed & -allowed);
}

SimdStatus forceSimdTarget(std::string_view name) {
  const int64_t available = machineTargets();
  if (name.empty()) {
    restrictTo(0);
    return SimdStatus::ok;
  }
  for (const NamedTarget& target : kTargets) {
    if (target.name != name) continue;
    if ((available & target.bit) == 0) return SimdStatus::unavailable;
    // the targets below stay: a kernel that is not compiled for this one takes the next
    restrictTo(available & ~((target.bit & -target.bit) - 1));
    return SimdStatus::ok;
  }
  return SimdStatus::unknown_name;
}

SimdStatus forceSimdTargetFromEnvironment() {
  static const SimdStatus status = [] {
    const char* name = std::getenv("NLG_SIMD");
    return name == nullptr || *name == '\0' ? SimdStatus::ok : forceSimdTarget(name);
  }();
  return status;
}

std::string simdRefusal(std::string_view name, SimdStatus status) {
  std::string text = "SIMD target '" + std::string(name.substr(0, 40)) + "' is ";
  text += status == SimdStatus::unknown_name ? "unknown" : "not available here";
  const char* separator = "; expected one of ";
  for (const std::string_view target : availableSimdTargets()) {
    text.append(separator).append(target);
    separator = ", ";
  }
  return text;
}

}  // namespace nlg
