// Records of the stages for measurements, beside their result.
#pragma once

#include <chrono>
#include <vector>

namespace nlg {

// Copies of theta at the words before the last: count x D each, of the functions that take a theta, in their order. Where a larger
// representation was taken, they are of the smallest.
struct ThetaTrace {
  std::vector<float> network, corrected;
  std::vector<float> fitted;  // of StageRunner and ThetaPolicy::make, before the refinement; of ThetaPolicy::bake, after it
};

inline float microsecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<float, std::micro>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace nlg
