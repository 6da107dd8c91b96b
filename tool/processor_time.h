// What work takes: of the processors, whatever else the machine does meanwhile, and by the clock.
#pragma once

#include <chrono>
#include <ctime>

namespace nlg {

// Seconds that all threads of this program have run so far: the cost of a piece of work is the difference of two.
inline double processorSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

inline double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace nlg
