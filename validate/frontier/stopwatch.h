// Microseconds since it was made, by the steady clock.
#pragma once

#include <chrono>

namespace nlg {

class Stopwatch {
 public:
  double elapsedUs() const { return std::chrono::duration<double, std::micro>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace nlg
