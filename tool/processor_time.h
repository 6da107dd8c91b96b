// Measures processor time and wall-clock time.
#pragma once

#include <chrono>
#include <ctime>

namespace nlg {

inline double secondsOf(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Seconds that all threads of this program have run so far, and this one: the cost of a piece of work is the difference of two.
inline double processorSeconds() { return secondsOf(CLOCK_PROCESS_CPUTIME_ID); }
inline double threadSeconds() { return secondsOf(CLOCK_THREAD_CPUTIME_ID); }

inline double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace nlg
