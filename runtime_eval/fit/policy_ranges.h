// Where the numbers of the policy may lie: the settings of the tools and the C interface refuse all others.
#pragma once

namespace nlg {

template <class Number>
struct PolicyRange {
  Number low, high;
};

struct PolicyRanges {
  PolicyRange<double> rmse{0.0, 1e3};  // bare_tent_rmse, good_rmse, retry_rmse, adam_rmse, and choice's enough_rmse
  PolicyRange<int> learned_steps{0, 64};
  PolicyRange<int> mirror_images{1, 8};
  PolicyRange<int> lm_iterations{0, 1000};  // and those from theta0
  PolicyRange<int> adam_steps{0, 1000000};
  PolicyRange<double> tau{1e-6, 1.0};  // tau_rmse, tau_leak, leak_share
  PolicyRange<int> refine_rounds{0, 16};
  PolicyRange<int> refine_first_steps{1, 100000};
  PolicyRange<int> refine_growth{1, 100};
  PolicyRange<double> refine_leak_weight{1.0, 1e6};
  PolicyRange<double> flat_ratio{1.0, 1e6};
  PolicyRange<double> generator_excess{1.0, 1e3};
};
inline constexpr PolicyRanges kPolicyRanges;

}  // namespace nlg
