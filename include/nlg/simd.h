// The vector instruction set that the whole library runs on.
//
// By itself every kernel takes the best one that this build and this machine have. Forcing one is for comparing bakes between
// machines, for measurements and for tests: results of different targets differ by rounding, except where a header says
// otherwise.
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

// What can be forced here, best first: some of avx512dl (AVX-512 of Ice Lake and Zen 4), avx512, avx2, sse4, ssse3, neon, scalar.
std::vector<std::string_view> availableSimdTargets();

// The one in use.
std::string_view chosenSimdTarget();

// Makes every kernel of the library use one target; an empty name goes back to the best. Without ok nothing changes.
// Call it while no other thread is inside the library: a call in progress could otherwise change targets half-way.
SimdStatus forceSimdTarget(std::string_view name);

// Forces what the environment variable NLG_SIMD names; without it, or with an empty one, nothing. The variable is read once a
// process: later calls return the first one's status and leave a target forced since then alone. Generator::load calls this.
SimdStatus forceSimdTargetFromEnvironment();

// Why a name was refused, in one line: "SIMD target 'neon' is not available here; expected one of avx512, avx2, …".
std::string simdRefusal(std::string_view name, SimdStatus status);

}  // namespace nlg
