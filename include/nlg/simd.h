// The choice of vector instructions (SIMD target) for the whole library.
//
// By default every kernel uses the best target of this build and machine. Forcing one is for comparing bakes between machines,
// for measurements and for tests. Results of different targets differ by rounding, unless a header says otherwise.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlg {

enum class SimdStatus {
  ok,
  unknown_name,  // not one of the names below on any machine
  unavailable,   // not compiled for this architecture, or not supported by this machine
};

// Returns the targets of this build and machine, best first: a subset of avx512, avx2, sse4, ssse3, neon,
// scalar.
std::vector<std::string_view> availableSimdTargets();

// Returns the target in use, as "avx2".
std::string_view chosenSimdTarget();

// Makes every kernel of the library use one target. No other thread may be inside the library: its call could change targets
// half-way.
//
// name      as "avx2"; empty: the best one again
// returns   ok; otherwise nothing has changed
SimdStatus forceSimdTarget(std::string_view name);

// Forces the target that the environment variable NLG_SIMD names; does nothing if it is not set or empty. The variable is read
// once per process: later calls return the status of the first and change nothing. Generator::load calls this.
SimdStatus forceSimdTargetFromEnvironment();

// Returns in one line why a name was refused: "SIMD target 'neon' is not available here; expected one of avx512, avx2, …".
std::string simdRefusal(std::string_view name, SimdStatus status);

}  // namespace nlg
