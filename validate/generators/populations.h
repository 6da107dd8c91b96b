// Populations of figures: all distinct functions, those that take a theta, hard ones; of the whole set or of the sample.
#pragma once

#include <cstdint>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "validate/generators/validation.h"

namespace nlg {

enum class Population : uint8_t {
  all,    // distinct functions; one that takes no theta counts as its bare tent at every word, with time 0
  theta,  // those that take a theta: the main one
  hard,   // whose bare tent has an RMSE of hard_tent_rmse or more: as published before there was a blend RMSE
};
inline constexpr int kPopulationCount = 3;
const char* populationName(Population population);

// A table never sets percentiles of the sample beside those of the whole set.
enum class Scope : uint8_t { set, sample };
inline constexpr int kScopeCount = 2;

class Populations {
 public:
  // By the check of every function's bare tent; the sample is spread evenly over the scenes of population theta.
  Populations(const FunctionSet& set, const ValidateOptions& options);

  bool takesTheta(uint64_t function) const { return takes_theta_[function]; }
  bool isHard(uint64_t function) const { return hard_[function]; }
  bool contains(Scope scope, Population population, uint64_t function) const;
  uint64_t count(Scope scope, Population population) const;
  // Rising.
  const std::vector<uint64_t>& sample() const { return sample_; }

 private:
  std::vector<uint64_t> chooseFrom(const std::vector<uint64_t>& functions, uint64_t wanted) const;

  const FunctionSet& set_;
  std::vector<uint8_t> takes_theta_, hard_, sampled_;  // by function
  std::vector<uint64_t> sample_;
};

// Functions of all scenes in turn, so that every stretch of the list holds all scenes: of each scene as many as of the others, or
// all that it has, at equal distances.
//
// scene_idx   N, < scene_count
// wanted      > 0; with fewer than so many functions all are taken
std::vector<uint64_t> chooseEvenly(const std::vector<uint32_t>& scene_idx, size_t scene_count, uint64_t wanted);

}  // namespace nlg
