// Functions that take the theta of another: it stands for their own samples, and lets no light through where their own would not.
#include "bake/function_sharing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime_eval/evaluator/evaluate.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

const Representation kNetwork{RepresentationKind::tent_mlp4};

// tent * sigmoid(steepness * (until - x)): as before a wall at `until`, which a steep one has.
Theta wallTheta(float until, float steepness) {
  const NetworkShape& shape = kNetwork.shape();
  Theta theta(static_cast<size_t>(shape.thetaCount()), 0.0f);
  // two units, x and -x, whose difference is a line
  theta[shape.w1()] = 1.0f;
  theta[shape.w1() + 3] = -1.0f;
  theta[shape.w3()] = -steepness / (1.0f + kNetwork.slope);
  theta[shape.w3() + 1] = steepness / (1.0f + kNetwork.slope);
  theta[shape.b3()] = steepness * until;
  return theta;
}

// Functions that are what their theta say, but for the samples' rounding, and valid everywhere.
class Functions {
 public:
  explicit Functions(const std::vector<Theta>& thetas) : validity_(kValidityByteCount, 0xff) {
    generators_.emplace_back(sampleGenerator(kNetwork, 24, 3, 1));
    AlignedFloats values(kSupportPointCount);
    const PointSet points = makePointSet(supportPattern().points);
    for (const Theta& theta : thetas) {
      evaluate(kNetwork, points, theta.data(), values.data());
      std::vector<uint8_t>& phi = phi_.emplace_back();
      for (int p = 0; p < kSupportPointCount; ++p) phi.push_back(static_cast<uint8_t>(std::lround(255.0f * values[p])));
      made_.emplace_back().theta = theta;
      made_.back().record.at(ThetaWord::stored) = check(made_.size() - 1, made_.size() - 1);
    }
  }

  StoredFunction function(uint64_t n) const { return {phi_[n].data(), validity_.data()}; }
  FunctionCheck check(uint64_t function_idx, uint64_t theta) {
    return checker_.check(kNetwork, function(function_idx), made_[theta].theta.data(), options);
  }
  SharedThetas share(double share_rmse, int threads = 2) const {
    return shareThetas(
        made_, generators_, [this](uint64_t n, std::vector<uint8_t>*) { return function(n); }, options, share_rmse, threads);
  }

  CheckOptions options;

 private:
  std::vector<uint8_t> validity_;
  std::vector<std::vector<uint8_t>> phi_;
  std::vector<Generator> generators_;
  std::vector<MadeTheta> made_;
  FunctionChecker checker_;
};

// More than are looked at together, and more than one theta can stand for.
std::vector<Theta> wallsBetween(float first, float last, int count) {
  std::vector<Theta> thetas;
  for (int i = 0; i < count; ++i)
    thetas.push_back(wallTheta(first + (last - first) * static_cast<float>(i * 7 % count) / static_cast<float>(count), 40.0f));
  return thetas;
}

TEST(SharedThetas, StandForEveryFunctionWithinWhatWasAskedFor) {
  Functions functions(wallsBetween(-0.4f, 0.4f, 300));
  const double share_rmse = 0.01;
  const SharedThetas shared = functions.share(share_rmse);
  uint64_t count = 0;
  for (uint64_t n = 0; n < 300; ++n) {
    const uint32_t whose = shared.whose[n];
    EXPECT_EQ(shared.whose[whose], whose) << "the theta of " << n << " is not stored";
    const FunctionCheck check = functions.check(n, whose);
    EXPECT_EQ(check.rmse, shared.check[n].rmse) << n;
    EXPECT_LE(check.blend_rmse, share_rmse) << n;
    EXPECT_TRUE(check.passes(functions.options)) << n;
    count += whose != n;
  }
  EXPECT_EQ(shared.count, count);
  // neighbours are .0027 apart: most do without a theta, and one does not do for all of them
  EXPECT_GT(count, 150u);
  EXPECT_LT(count, 299u);
}

TEST(SharedThetas, AreTheSameForAnyNumberOfThreads) {
  const Functions functions(wallsBetween(-0.4f, 0.4f, 700));
  EXPECT_EQ(functions.share(0.005, 1).whose, functions.share(0.005, 3).whose);
}

TEST(SharedThetas, AreFewerTheLessMayBeLost) {
  const Functions functions(wallsBetween(-0.4f, 0.4f, 300));
  const uint64_t few = functions.share(0.004).count, many = functions.share(0.02).count;
  EXPECT_GT(few, 0u);
  EXPECT_GT(many, few);
}

TEST(SharedThetas, KeepWhatWouldLeak) {
  // behind the wall of the second the first has all of its tent, and in front of it they are the same
  Functions functions({wallTheta(9.0f, 40.0f), wallTheta(0.7f, 200.0f)});
  functions.options.tau_rmse = 1.0;
  const FunctionCheck leaking = functions.check(1, 0);
  ASSERT_LT(leaking.rmse, functions.options.tau_rmse);
  ASSERT_GT(leaking.blend_rmse, functions.options.tau_blend);
  ASSERT_LT(leaking.blend_rmse, 1.0);
  EXPECT_EQ(functions.share(1.0).whose[1], 1u);
}

TEST(SharedThetas, MayBeNoWorseThanOnesOwnWhateverWasAskedFor) {
  Functions functions({wallTheta(0.1f, 40.0f), wallTheta(0.1f, 40.0f), wallTheta(-0.3f, 40.0f)});
  const SharedThetas shared = functions.share(1e-9);
  EXPECT_EQ(shared.count, 1u) << "the same theta twice";
  EXPECT_EQ(shared.whose[0], shared.whose[1]);
  EXPECT_EQ(shared.whose[2], 2u);
}

TEST(SharedThetas, OfNoFunctionsAreNone) { EXPECT_EQ(Functions({}).share(0.01).count, 0u); }

}  // namespace
}  // namespace nlg
