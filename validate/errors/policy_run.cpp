#include "validate/errors/policy_run.h"

#include <algorithm>
#include <memory>

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

  // functions, made   of one batch
  // use               with the number inside the batch
  void run(const StoredFunction* functions, int count, MadeTheta* made,
           const std::function<void(int i, const ThetaByWord& theta)>& use) {
    ThetaTrace trace;
    policy_.bake(functions, count, made, traces_ ? &trace : nullptr);
    if (!use) return;
    size_t at = 0;  // in the trace
    for (int i = 0; i < count; ++i) {
      ThetaByWord theta{};
      if (!made[i].isBareTent()) {
        if (traces_) theta = {&trace.network[at], &trace.corrected[at], &trace.fitted[at], nullptr};
        theta.back() = made[i].theta.data();
        at += theta_count_;
      }
      use(i, theta);
    }
  }

 private:
  ThetaPolicy policy_;
  bool traces_;
  size_t theta_count_;
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
    threads[thread]->run(&functions[begin], static_cast<int>(end - begin), &made[begin],
                         use ? useOne : std::function<void(int, const ThetaByWord&)>());
  });
  return made;
}

}  // namespace nlg
