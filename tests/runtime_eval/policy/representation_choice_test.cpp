#include "runtime_eval/policy/representation_choice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nlg {
namespace {

// By rising number of parameters.
std::vector<FunctionCheck> checksOf(const std::vector<double>& rmse) {
  std::vector<FunctionCheck> checks(rmse.size());
  for (size_t i = 0; i < rmse.size(); ++i) checks[i].rmse = checks[i].blend_rmse = rmse[i];
  return checks;
}

TEST(ChooseRepresentation, TakesTheSmallestWhereErrorsFlatten) {
  const ChoiceOptions options{.choice_flat_ratio = 1.5, .choice_enough_rmse = 0.001};
  EXPECT_EQ(chooseRepresentation(checksOf({0.010, 0.009, 0.008, 0.0079}), {}, options), 0);
  EXPECT_EQ(chooseRepresentation(checksOf({0.015, 0.006, 0.005, 0.0045}), {}, options), 1);
  EXPECT_EQ(chooseRepresentation(checksOf({0.015, 0.012, 0.009, 0.004}), {}, options), 3);
}

TEST(ChooseRepresentation, StopsAtAnErrorThatIsEnough) {
  const ChoiceOptions options{.choice_flat_ratio = 1.5, .choice_enough_rmse = 0.005};
  EXPECT_EQ(chooseRepresentation(checksOf({0.010, 0.0049, 0.001}), {}, options), 1);
  EXPECT_EQ(chooseRepresentation(checksOf({0.010, 0.006, 0.001}), {}, options.forPredicted()), 0);
}

TEST(ChooseRepresentation, PrefersOneThatPassesTheCheck) {
  // flat at once, but too wrong: the first that is flat and passes
  EXPECT_EQ(chooseRepresentation(checksOf({0.045, 0.044, 0.019}), {}, {}), 2);
  // nobody passes: the first that is flat
  EXPECT_EQ(chooseRepresentation(checksOf({0.09, 0.04, 0.035}), {}, {}), 1);
  std::vector<FunctionCheck> leaking = checksOf({0.001, 0.001});
  leaking[0].rmse = 0.5;
  EXPECT_EQ(chooseRepresentation(leaking, {}, {}), 1);
  // one that passes is not given up for a better one that fails
  leaking = checksOf({0.015, 0.009});
  leaking[1].rmse = 0.5;
  EXPECT_EQ(chooseRepresentation(leaking, {}, {.choice_enough_rmse = 0.001}), 0);
}

TEST(ChooseRepresentation, NeverTakesWhatIsNotFiniteWhenOthersAre) {
  EXPECT_EQ(chooseRepresentation(checksOf({NAN, 0.01}), {}, {}), 1);
  EXPECT_EQ(chooseRepresentation(checksOf({0.01, NAN}), {}, {}), 0);
  EXPECT_EQ(chooseRepresentation(checksOf({NAN}), {}, {}), 0);
  EXPECT_EQ(chooseRepresentation(checksOf({0.01}), {}, {}), 0);
}

}  // namespace
}  // namespace nlg
