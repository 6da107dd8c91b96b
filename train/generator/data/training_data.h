// The functions of a training set and what a generator reads of them, in memory or in a function cache.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/generator/projection.h"
#include "train/generator/data/function_cache.h"
#include "train/generator/data/sample_order.h"

namespace nlg {

using Scenes = std::map<std::string, std::string>;  // id → SHA-256 of the geometry, or empty

// A scene of `held_out` and the one of `seen` that it is: by name, or a copy under another name. Two empty names: none is.
std::pair<std::string, std::string> seenScene(const Scenes& seen, const Scenes& held_out);

// stored: as the set holds them; cache: in a cache's order, so that training takes the same functions from both.
enum class FunctionOrder { stored, cache };

class TrainingData {
 public:
  // Projects every function once, unless samples are read; mirror images need no more than signs.
  // basis   the one that coefficients are projected with
  // used    … and the one that they are of: as much of it, divided otherwise (whitened)
  TrainingData(FunctionSet set, const BasisData& basis, const BasisData& used, FunctionOrder order = FunctionOrder::stored);
  // basis   the one that the cache was made with
  // used    … and the one that coefficients are of: those of largest variance (truncateBasis), divided otherwise (whitened)
  TrainingData(std::unique_ptr<FunctionCache> cache, const BasisData& basis, const BasisData& used);

  int64_t functionCount() const { return function_count_; }
  // Numbers that the network reads of a function: coefficients, or parity classes of samples.
  int inputCount() const { return input_ == GeneratorInput::samples ? kSampleInputCount : coefficient_count_; }
  const std::string& sha256() const { return cache_ ? cache_->origin().training_set_sha256 : set_.sha256; }
  const Scenes& scenes() const { return cache_ ? cache_->origin().scenes : set_.scene_sha256; }
  FunctionCache* cache() const { return cache_.get(); }  // null when the functions lie in memory

  StoredFunction function(int64_t index) const;

  // What the network reads of the sample's function, mirrored; inputCount() floats.
  void copyInput(const Sample& sample, float* input) const;

  // Functions whose bare tent has a blend RMSE above `tent_rmse`, rising.
  std::vector<uint32_t> functionsAbove(double tent_rmse) const;

 private:
  int64_t placeInSet(int64_t index) const { return order_.empty() ? index : order_[static_cast<size_t>(index)]; }
  const float* coefficients(int64_t index) const;
  void copyCoefficients(int64_t index, int mirror, float* coefficients) const;

  FunctionSet set_;
  std::vector<uint32_t> order_;      // by index: place in set_; empty: the same
  std::vector<float> coefficients_;  // N x stored_count_, as set_
  std::unique_ptr<FunctionCache> cache_;
  int64_t function_count_;
  GeneratorInput input_;
  int coefficient_count_;
  int stored_count_;  // coefficients a function has in memory or in the cache
  std::array<int, kParityClassCount> class_count_, stored_class_count_;
  std::vector<float> factor_;  // K: from the stored coefficients to those that are used
};

}  // namespace nlg
