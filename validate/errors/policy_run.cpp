#include "validate/errors/policy_run.h"

#include <algorithm>
#include <memory>

#include "tool/parallel_for.h"

namespace nlg {

std::vector<MadeTheta> runPolicy(const std::vector<const Generator*>& generators, const std::vector<StoredFunction>& functions,
                                 const PolicyOptions& policy, const PolicyRunOptions& options, const UseTheta& use) {
  std::vector<std::unique_ptr<ThetaPolicy>> policies;  // by thread
  for (int t = 0; t < options.threads; ++t) policies.push_back(std::make_unique<ThetaPolicy>(generators, policy));
  const bool traces = use && generators.size() == 1;
  const auto theta_count = static_cast<size_t>(generators.front()->representation().thetaCount());
  std::vector<MadeTheta> made(functions.size());
  const auto batch = static_cast<uint64_t>(options.batch);
  parallelForBlocks(functions.size(), batch, options.threads, [&](uint64_t begin, uint64_t end, int thread) {
    ThetaTrace trace;
    policies[thread]->bake(&functions[begin], static_cast<int>(end - begin), &made[begin], traces ? &trace : nullptr);
    size_t at = 0;  // in the trace
    for (uint64_t i = begin; use && i < end; ++i) {
      ThetaByWord theta{};
      if (!made[i].isBareTent()) {
        if (traces) theta = {&trace.network[at], &trace.corrected[at], &trace.fitted[at], nullptr};
        theta.back() = made[i].theta.data();
        at += theta_count;
      }
      use(thread, i, made[i], theta);
    }
  });
  return made;
}

}  // namespace nlg
