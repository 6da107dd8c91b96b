#include "validate/frontier/generator_run.h"

#include <utility>

#include "validate/frontier/stopwatch.h"

namespace nlg {

GeneratorRun::GeneratorRun(std::shared_ptr<const Generator> generator, const CorrectionOptions& correction)
    : generator_(std::move(generator)),
      scratch_(*generator_),
      corrector_(*generator_, correction),
      theta_(static_cast<size_t>(kBatchCount) * static_cast<size_t>(representation().thetaCount())) {}

std::vector<FittedFunction> GeneratorRun::generate(const FunctionBlock& block) { return fitted(block, generateTheta(block)); }

std::vector<FittedFunction> GeneratorRun::generateAndCorrect(const FunctionBlock& block) {
  const double generator_us = generateTheta(block);
  return fitted(block, generator_us + correctTheta(block));
}

double GeneratorRun::generateTheta(const FunctionBlock& block) {
  const Stopwatch watch;
  generator_->generate(block.phi.data(), block.count(), theta_.data(), &scratch_);
  return watch.elapsedUs() / block.count();
}

double GeneratorRun::correctTheta(const FunctionBlock& block) {
  const Stopwatch watch;
  corrector_.correct(block.stored.data(), block.count(), theta_.data());
  return watch.elapsedUs() / block.count();
}

std::vector<FittedFunction> GeneratorRun::fitted(const FunctionBlock& block, double elapsed_us) const {
  const auto D = static_cast<size_t>(representation().thetaCount());
  std::vector<FittedFunction> functions;
  for (size_t i = 0; i < block.functions.size(); ++i) {
    functions.push_back({representation(), Theta(&theta_[i * D], &theta_[i * D] + D), elapsed_us});
  }
  return functions;
}

}  // namespace nlg
