// What became of one function in one representation: its checks, how long it took, and which stage made its theta what it is.
#pragma once

#include <array>
#include <chrono>
#include <numeric>
#include <vector>

#include "runtime_eval/fit/fit_result.h"
#include "runtime_eval/fit/function_check.h"
#include "runtime_eval/fit/theta_stage.h"

namespace nlg {

struct ThetaRecord {
  std::array<FunctionCheck, kThetaWordCount> check;  // of theta, by ThetaWord
  std::array<float, kThetaWordCount> word_us{};      // what it took to come from the word before to this one, by the steady clock
  std::array<float, kThetaStageCount> stage_us{};    // the same by ThetaStage; of what runs in batches, a function's share
  ThetaStage ended = ThetaStage::network;            // that made theta what it is; bare_tent: there is none
  bool took_fit = false;                      // any step of Adam or Levenberg–Marquardt, kept or not, in any representation
  bool refined = false;                       // took the refinement …
  FitStop refinement_stop = FitStop::budget;  // … whose last fit ended so

  const FunctionCheck& at(ThetaWord word) const { return check[static_cast<size_t>(word)]; }
  FunctionCheck& at(ThetaWord word) { return check[static_cast<size_t>(word)]; }
  void addTime(ThetaStage stage, ThetaWord word, float elapsed_us) {
    stage_us[static_cast<size_t>(stage)] += elapsed_us;
    word_us[static_cast<size_t>(word)] += elapsed_us;
  }
  // From the function to this word.
  double elapsedUs(ThetaWord word) const {
    return std::accumulate(word_us.begin(), word_us.begin() + static_cast<ptrdiff_t>(word) + 1, 0.0);
  }
};

inline float microsecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<float, std::micro>(std::chrono::steady_clock::now() - start).count();
}

// Copies of theta at the words before the last, for whoever measures them: count x D each, of the functions that take a theta, in
// their order. Where a larger representation was taken, they are of the smallest.
struct ThetaTrace {
  std::vector<float> network, corrected;
  std::vector<float> fitted;  // of StageRunner and ThetaPolicy::make, before the refinement; of ThetaPolicy::bake, after it
};

}  // namespace nlg
