#include "train/generator/training_data.h"

#include <algorithm>
#include <numeric>

#include "runtime_eval/support/random.h"

namespace nlg {

TrainingData::TrainingData(FunctionSet set, const BasisData& basis)
    : set_(std::move(set)), coefficient_count_(basis.coefficientCount()), class_count_(basis.class_count) {
  const Projection projection(basis);
  ProjectionScratch scratch(GeneratorPrecision::float32);
  const auto count = static_cast<int64_t>(set_.functionCount());
  coefficients_.resize(size_t(count) * coefficient_count_);
  for (int64_t begin = 0; begin < count; begin += kBatchCount) {
    const int batch = static_cast<int>(std::min<int64_t>(kBatchCount, count - begin));
    projection.project(&set_.phi[size_t(begin) * kSupportPointCount], batch, &coefficients_[size_t(begin) * coefficient_count_],
                       &scratch);
  }
}

StoredFunction TrainingData::function(int64_t index) const {
  return {&set_.phi[size_t(index) * kSupportPointCount], &set_.validity[size_t(index) * kValidityByteCount]};
}

void TrainingData::copyCoefficients(int64_t index, int mirror, float* coefficients) const {
  const float* source = &coefficients_[size_t(index) * coefficient_count_];
  for (int c = 0; c < kParityClassCount; ++c) {
    const float sign = mirrorSign(c, mirror);
    for (int k = 0; k < class_count_[c]; ++k) *coefficients++ = sign * *source++;
  }
}

SampleOrder::SampleOrder(int64_t function_count, int batch, int point_batch_count, uint64_t seed)
    : function_count_(function_count),
      batch_(batch),
      point_batch_count_(point_batch_count),
      seed_(seed),
      order_(function_count) {}

void SampleOrder::shuffle(int64_t epoch) {
  epoch_ = epoch;
  Random random(mixSeed(seed_, 1, static_cast<uint64_t>(epoch)));
  std::iota(order_.begin(), order_.end(), 0u);
  for (size_t i = order_.size(); i > 1; --i) std::swap(order_[i - 1], order_[random.below(static_cast<uint32_t>(i))]);
}

std::vector<Sample> SampleOrder::samples(int64_t step) {
  Random random(mixSeed(seed_, 2, static_cast<uint64_t>(step)));
  std::vector<Sample> samples(batch_);
  for (int b = 0; b < batch_; ++b) {
    const int64_t position = step * batch_ + b;
    if (position / function_count_ != epoch_) shuffle(position / function_count_);
    samples[b].function = order_[position % function_count_];
    samples[b].mirror = static_cast<int>(random.below(kMirrorCount));
    samples[b].batch = static_cast<int>(random.below(static_cast<uint32_t>(point_batch_count_)));
  }
  return samples;
}

}  // namespace nlg
