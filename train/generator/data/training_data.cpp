#include "train/generator/data/training_data.h"

#include <algorithm>
#include <functional>

namespace nlg {
namespace {

// What makes coefficients of `basis` into those of `used`, whose classes begin with the same components.
std::vector<float> factors(const BasisData& basis, const BasisData& used) {
  std::vector<float> result;
  int stored = 0, taken = 0;
  for (int c = 0; c < kParityClassCount; ++c) {
    for (int k = 0; k < used.class_count[c]; ++k) result.push_back(basis.deviation[stored + k] / used.deviation[taken + k]);
    stored += basis.class_count[c];
    taken += used.class_count[c];
  }
  return result;
}

}  // namespace

std::pair<std::string, std::string> seenScene(const Scenes& seen, const Scenes& held_out) {
  for (const auto& [scene, sha256] : held_out) {
    for (const auto& [other, other_sha256] : seen) {
      if (scene == other || (!sha256.empty() && sha256 == other_sha256)) return {scene, other};
    }
  }
  return {};
}

TrainingData::TrainingData(FunctionSet set, const BasisData& basis, const BasisData& used, FunctionOrder order)
    : set_(std::move(set)),
      function_count_(static_cast<int64_t>(set_.functionCount())),
      input_(used.input),
      coefficient_count_(used.coefficientCount()),
      stored_count_(basis.coefficientCount()),
      class_count_(used.class_count),
      stored_class_count_(basis.class_count) {
  if (order == FunctionOrder::cache) order_ = cacheOrder(function_count_);
  if (input_ == GeneratorInput::samples) return;
  factor_ = factors(basis, used);
  const Projection projection(basis);
  ProjectionScratch scratch;
  coefficients_.resize(size_t(function_count_) * stored_count_);
  for (int64_t begin = 0; begin < function_count_; begin += kBatchCount) {
    const int batch = static_cast<int>(std::min<int64_t>(kBatchCount, function_count_ - begin));
    std::vector<StoredFunction> functions;
    for (int i = 0; i < batch; ++i) functions.push_back(storedFunction(set_, static_cast<size_t>(begin + i)));
    projection.project(functions.data(), batch, &coefficients_[size_t(begin) * stored_count_], &scratch);
  }
}

TrainingData::TrainingData(std::unique_ptr<FunctionCache> cache, const BasisData& basis, const BasisData& used)
    : cache_(std::move(cache)),
      function_count_(cache_->functionCount()),
      input_(used.input),
      coefficient_count_(used.coefficientCount()),
      stored_count_(cache_->coefficientCount()),
      class_count_(used.class_count),
      stored_class_count_(basis.class_count) {
  if (input_ == GeneratorInput::coefficients) factor_ = factors(basis, used);
}

StoredFunction TrainingData::function(int64_t index) const {
  if (cache_) return cache_->function(index);
  return storedFunction(set_, static_cast<size_t>(placeInSet(index)));
}

const float* TrainingData::coefficients(int64_t index) const {
  if (cache_) return cache_->coefficients(index);
  return &coefficients_[static_cast<size_t>(placeInSet(index)) * stored_count_];
}

void TrainingData::copyInput(const Sample& sample, float* input) const {
  if (input_ == GeneratorInput::coefficients) return copyCoefficients(sample.function, sample.mirror, input);
  const StoredFunction function = this->function(sample.function);
  if (sample.visibility_only)
    visibilityClasses(function, input);
  else
    sampleClasses(function, input);
  const int length = nlg::inputCount(input_);
  for (int c = 0; c < kParityClassCount; ++c, input += length) {
    if (mirrorSign(c, sample.mirror) < 0.0f) std::transform(input, input + length, input, std::negate<>());
  }
}

void TrainingData::copyCoefficients(int64_t index, int mirror, float* coefficients) const {
  // mirroring changes no more than signs, by parity class
  const float* stored = this->coefficients(index);
  const float* factor = factor_.data();
  for (int c = 0; c < kParityClassCount; ++c) {
    const float sign = mirrorSign(c, mirror);
    for (int k = 0; k < class_count_[c]; ++k) *coefficients++ = sign * stored[k] * *factor++;
    stored += stored_class_count_[c];
  }
}

std::vector<uint32_t> TrainingData::functionsAbove(double tent_rmse) const {
  std::vector<uint32_t> above;
  for (int64_t i = 0; i < function_count_; ++i) {
    const float rmse = cache_ ? cache_->tentRmse(i) : tentRmse(function(i));
    if (static_cast<double>(rmse) > tent_rmse) above.push_back(static_cast<uint32_t>(i));
  }
  return above;
}

}  // namespace nlg
