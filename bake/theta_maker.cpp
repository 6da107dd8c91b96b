#include "bake/theta_maker.h"

#include <algorithm>
#include <chrono>
#include <cstring>

namespace nlg {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Who is corrected is decided by the check (make).
CorrectionOptions allOf(CorrectionOptions options) {
  options.correct_rmse = 0.0;
  return options;
}

}  // namespace

ThetaMaker::ThetaMaker(const std::vector<Generator>& generators, const BakeOptions& options, const BakeSavings& savings)
    : generators_(generators), options_(options), savings_(savings), phi_(static_cast<size_t>(kBatchCount) * kSupportPointCount) {
  for (const Generator& generator : generators) {
    scratch_.emplace_back(generator);
    corrector_.emplace_back(generator, allOf(options.correction));
    theta_.emplace_back(static_cast<size_t>(kBatchCount) * generator.representation().thetaCount());
  }
}

std::vector<FunctionCheck> ThetaMaker::make(const std::vector<StoredFunction>& functions, size_t g) {
  const Clock::time_point start = Clock::now();
  for (size_t i = 0; i < functions.size(); ++i) {
    std::memcpy(&phi_[i * kSupportPointCount], functions[i].phi, kSupportPointCount);
  }
  generators_[g].generate(phi_.data(), static_cast<int>(functions.size()), theta_[g].data(), &scratch_[g]);
  work_.generator_s += secondsSince(start);
  const Clock::time_point check_start = Clock::now();
  std::vector<FunctionCheck> checks;
  std::vector<size_t> wrong;
  for (size_t i = 0; i < functions.size(); ++i) {
    checks.push_back(check(functions[i], g, theta(g, i)));
    const bool right = checks[i].rmse <= options_.correction.correct_rmse && checks[i].passes(options_.refinement.check);
    ++work_.checked;
    work_.right += right;
    if (!right || !savings_.correction) wrong.push_back(i);
  }
  work_.check_s += secondsSince(check_start);
  if (!wrong.empty() && !corrector_[g].empty()) correct(functions, wrong, g, &checks);
  return checks;
}

// A lower error may leak more: what passed the check and would no longer stays as it was.
void ThetaMaker::correct(const std::vector<StoredFunction>& functions, const std::vector<size_t>& wrong, size_t g,
                         std::vector<FunctionCheck>* checks) {
  const Clock::time_point start = Clock::now();
  std::vector<StoredFunction> wrong_functions;
  std::vector<float> wrong_theta;
  for (const size_t i : wrong) {
    wrong_functions.push_back(functions[i]);
    wrong_theta.insert(wrong_theta.end(), theta(g, i), theta(g, i) + thetaCount(g));
  }
  work_.corrected +=
      static_cast<uint64_t>(corrector_[g].correct(wrong_functions.data(), static_cast<int>(wrong.size()), wrong_theta.data()));
  for (size_t n = 0; n < wrong.size(); ++n) {
    FunctionCheck& made = (*checks)[wrong[n]];
    const float* corrected_theta = &wrong_theta[n * thetaCount(g)];
    const FunctionCheck corrected = check(wrong_functions[n], g, corrected_theta);
    if (made.passes(options_.refinement.check) && !corrected.passes(options_.refinement.check)) {
      --work_.corrected;
      continue;
    }
    made = corrected;
    std::copy_n(corrected_theta, thetaCount(g), &theta_[g][wrong[n] * thetaCount(g)]);
  }
  work_.correction_s += secondsSince(start);
}

void ThetaMaker::makeCorrected(const StoredFunction& function, size_t g) {
  generators_[g].generate(function.phi, 1, theta_[g].data(), &scratch_[g]);
  work_.corrected += static_cast<uint64_t>(corrector_[g].correct(&function, 1, theta_[g].data()));
}

FunctionCheck ThetaMaker::check(const StoredFunction& function, size_t g, const float* theta) {
  return checker_.check(generators_[g].representation(), function, theta, options_.refinement.check);
}

}  // namespace nlg
