// What work takes by the clock.
#pragma once

#include <chrono>

namespace nlg {

inline double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace nlg
