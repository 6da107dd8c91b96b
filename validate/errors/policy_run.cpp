#include "validate/errors/policy_run.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

// One of these a thread.
class BatchRun {
 public:
  BatchRun(const std::vector<const Generator*>& generators, const PolicyOptions& options)
      : policy_(generators, options), traces_(generators.size() == 1) {
    theta_count_ = static_cast<size_t>(generators.front()->representation().thetaCount());
  }

  // first             the batch's first function, for errors
  // functions, made   of one batch
  // use               with the number inside the batch
  void run(uint64_t first, const StoredFunction* functions, int count, MadeTheta* made,
           const std::function<void(int i, const ThetaByWord& theta)>& use) {
    splitOffTents(functions, count, made);
    std::vector<MadeTheta> results(with_theta_.size());
    ThetaTrace trace;
    policy_.make(with_theta_.data(), static_cast<int>(with_theta_.size()), results.data(), traces_ ? &trace : nullptr);
    for (size_t n = 0; n < results.size(); ++n) {
      MadeTheta& one = results[n];
      policy_.refine(with_theta_[n], &one);
      const Theta fitted = one.theta;  // the trace ends before the refinement
      if (!policy_.round(with_theta_[n], &one)) {
        const auto largest =
            std::max_element(fitted.begin(), fitted.end(), [](float a, float b) { return std::fabs(a) < std::fabs(b); });
        throw NumericalError("validate", "function " + std::to_string(first + numbers_[n]), "theta, for float16,", *largest);
      }
      made[numbers_[n]] = one;
      if (!use) continue;
      ThetaByWord theta{};
      if (traces_) theta = {&trace.network[n * theta_count_], &trace.corrected[n * theta_count_], fitted.data(), nullptr};
      theta.back() = one.theta.data();
      use(numbers_[n], theta);
    }
    if (!use) return;
    for (int i = 0; i < count; ++i) {
      if (made[i].isBareTent()) use(i, {});
    }
  }

 private:
  void splitOffTents(const StoredFunction* functions, int count, MadeTheta* made) {
    with_theta_.clear();
    numbers_.clear();
    for (int i = 0; i < count; ++i) {
      const FunctionCheck tent = policy_.checkBareTent(functions[i]);
      made[i] = {};
      made[i].record.check.fill(tent);
      made[i].record.ended = ThetaStage::bare_tent;
      if (takesBareTent(tent, policy_.options())) continue;
      with_theta_.push_back(functions[i]);
      numbers_.push_back(i);
    }
  }

  ThetaPolicy policy_;
  bool traces_;
  size_t theta_count_;
  std::vector<StoredFunction> with_theta_;
  std::vector<int> numbers_;  // of these in the batch
};

}  // namespace

std::vector<MadeTheta> runPolicy(const std::vector<const Generator*>& generators, const std::vector<StoredFunction>& functions,
                                 const PolicyOptions& policy, const PolicyRunOptions& options, const UseTheta& use) {
  std::vector<std::unique_ptr<BatchRun>> threads;
  for (int t = 0; t < options.threads; ++t) threads.push_back(std::make_unique<BatchRun>(generators, policy));
  std::vector<MadeTheta> made(functions.size());
  const auto batch = static_cast<uint64_t>(options.batch);
  parallelFor((functions.size() + batch - 1) / batch, options.threads, [&](uint64_t b, int thread) {
    const uint64_t begin = b * batch, end = std::min<uint64_t>(begin + batch, functions.size());
    const auto useOne = [&](int i, const ThetaByWord& theta) { use(thread, begin + i, made[begin + i], theta); };
    threads[thread]->run(begin, &functions[begin], static_cast<int>(end - begin), &made[begin],
                         use ? useOne : std::function<void(int, const ThetaByWord&)>());
  });
  return made;
}

}  // namespace nlg
