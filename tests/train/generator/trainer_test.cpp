#include "train/generator/run/trainer.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <fstream>

#include "tests/damage.h"
#include "tests/input_error.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/temporary_folder.h"
#include "tests/train/sample_set.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "train/generator/run/loss_guard.h"
#include "train/generator/run/worst_functions.h"

namespace nlg {
namespace {

const Representation kTrainedKind = Representation::tentMlp(0.01f);
const RunIdentity kIdentity{"tent_mlp", R"({"steps":40})", "basis", "training set"};

// A small run: 24 functions, 25 coefficients.
struct Run {
  Run()
      : training(sampleSet(24, 1), sampleBasis(kSampleClasses, 3), sampleBasis(kSampleClasses, 3)),
        held_out(sampleSet(6, 500), sampleBasis(kSampleClasses, 3), sampleBasis(kSampleClasses, 3)) {
    options.steps = 40;
    options.batch = 16;
    options.learning_rate = 3e-3;
    options.checkpoint_steps = 20;
    options.shape.coefficient_count = training.inputCount();
    options.shape.width = 32;
    options.shape.layer_count = 3;
    theta0[ThetaLayout::b3] = 1.0f;  // the bare tent, and hidden units that can learn
    const Theta random = randomTheta({}, 2);
    for (int i = 0; i < ThetaLayout::b3; ++i) theta0[i] = 0.3f * random[i];
  }

  TrainOptions options;
  Theta theta0 = Theta(ThetaLayout::count);
  TrainingData training, held_out;
};

const Run& run() {
  static const Run shared;
  return shared;
}

TrainingState freshState() { return makeState(run().options, run().theta0); }

// Training from `state` on; stops as a killed process would, behind the checkpoint of step `killed_at`.
struct Killed {};
void trainUntil(TrainingState& state, int64_t killed_at, const std::string& path) {
  try {
    train(run().options, kTrainedKind, run().training, run().held_out, &state, [&] {
      if (!path.empty()) writeCheckpoint(path, kIdentity, state);
      if (state.step == killed_at) throw Killed{};
    });
  } catch (const Killed&) {
  }
}

void expectSame(const std::vector<torch::Tensor>& a, const std::vector<torch::Tensor>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_TRUE(torch::equal(a[i], b[i])) << what << ", parameter " << i;
}

class Checkpoint : public testing::Test {
 protected:
  bool refused(const RunIdentity& identity = kIdentity) const {
    TrainingState state = freshState();
    const std::string error = inputErrorOf([&] { readCheckpoint(CheckpointFile(path_), identity, &state); });
    if (error == "no error") return false;
    EXPECT_EQ(error.rfind(path_, 0), 0u) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return true;
  }

  void writeFresh() const { writeCheckpoint(path_, kIdentity, freshState()); }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "run.ckpt";
};

TEST(Train, LowersTheLoss) {
  TrainingState state = freshState();
  const HeldOutError before = heldOutError(state.network, kTrainedKind, run().training, CheckOptions().loss(), 24);
  int saves = 0;
  const TrainReport report = train(run().options, kTrainedKind, run().training, run().held_out, &state, [&] { ++saves; });
  EXPECT_EQ(state.step, 40);
  EXPECT_EQ(saves, 2);
  for (GeneratorNetwork* network : {&state.network, &state.average}) {  // the average follows
    const HeldOutError after = heldOutError(*network, kTrainedKind, run().training, CheckOptions().loss(), 24);
    EXPECT_LT(after.network, before.network);
    EXPECT_LT(after.final, before.final);
  }
  const HeldOutError held_out = heldOutError(state.average, kTrainedKind, run().held_out, CheckOptions().loss(), 2048);
  EXPECT_EQ(report.held_out.network, held_out.network);
  EXPECT_EQ(report.held_out.final, held_out.final);
  EXPECT_EQ(std::count(state.log_csv.begin(), state.log_csv.end(), '\n'), 3) << state.log_csv;
}

TEST(Train, RaisesOnNumbersThatAreNotFinite) {
  Theta theta0 = run().theta0;
  theta0[3] = NAN;
  TrainingState state = makeState(run().options, theta0);
  EXPECT_THROW(train(run().options, kTrainedKind, run().training, run().held_out, &state, [] {}), NumericalError);
  EXPECT_EQ(state.step, 0);
  EXPECT_EQ(state.rollbacks, LossGuard::kMaxRollbacks);
  EXPECT_EQ(state.draw, LossGuard::kMaxRollbacks + 1) << "every attempt takes other samples";

  TrainOptions wild = run().options;
  wild.learning_rate = 1e3;
  wild.shape.output_scale = 1e12;  // errors beyond float: a finite one, however large, is capped
  TrainingState diverging = makeState(wild, run().theta0);
  wild.gradient_clip = 1e9;
  int saves = 0;
  EXPECT_THROW(train(wild, kTrainedKind, run().training, run().held_out, &diverging, [&] { ++saves; }), NumericalError);
  EXPECT_EQ(saves, 0) << "a state gone wrong must not replace a good one";
}

TEST(TrainStep, CapsTheLossOfAThetaGoneAstray) {
  TrainOptions options = run().options;
  options.shape.exact_last_layer = false;
  Theta theta0 = run().theta0;
  theta0[ThetaLayout::b3] = 1e4f;
  TrainingState state = makeState(options, theta0);
  const ProcessGroup alone;
  TrainStep step(options, kTrainedKind, run().training, state, alone);
  const TrainStep::Result result = step.computeGradient(state);
  // the root of the weight of dark points, which is the largest
  EXPECT_EQ(result.loss, std::sqrt(options.loss.dark_weight));
  EXPECT_EQ(result.gradient_norm, 0.0) << "such a theta pulls nowhere";
}

TEST(Train, GivesTheSameParametersOnAnyNumberOfThreads) {
  TrainingState one = freshState(), three = freshState();
  TrainOptions options = run().options;
  options.steps = 10;
  const TrainReport of_one = train(options, kTrainedKind, run().training, run().held_out, &one, [] {});
  options.threads = 3;
  const TrainReport of_three = train(options, kTrainedKind, run().training, run().held_out, &three, [] {});
  expectSame(one.network->parameters(), three.network->parameters(), "network");
  expectSame(one.average->parameters(), three.average->parameters(), "average");
  EXPECT_EQ(of_one.held_out.final, of_three.held_out.final);
}

// Adam, clipping and averages as libtorch has them, on a gradient of known numbers.
TEST(TakeStep, IsLibtorchsAdamWithClippingAndAverages) {
  GeneratorNetwork network(run().options.shape, run().theta0, 1), average(run().options.shape, run().theta0, 2),
      peer(run().options.shape, run().theta0, 1), peer_average(run().options.shape, run().theta0, 2);
  ParameterMoments moments = zeroMoments(network);
  BatchGradient gradient(network);
  torch::optim::Adam adam(peer->parameters(), torch::optim::AdamOptions(0.01).betas({0.9, 0.99}));
  for (int64_t number = 1; number <= 5; ++number) {
    // a loss whose gradient is the parameters themselves, times a half in each of two parts
    gradient.compute(network, 2, 2, [&](int) {
      torch::Tensor loss = torch::zeros({});
      for (const torch::Tensor& parameter : network->parameters()) loss = loss + parameter.square().sum() / 4;
      return loss;
    });
    adam.zero_grad();
    torch::Tensor loss = torch::zeros({});
    for (const torch::Tensor& parameter : peer->parameters()) loss = loss + parameter.square().sum() / 2;
    loss.backward();
    EXPECT_NEAR(gradient.loss(), loss.item<double>(), 1e-5 * loss.item<double>());
    const double norm = torch::nn::utils::clip_grad_norm_(peer->parameters(), 0.5);
    EXPECT_NEAR(gradient.norm(), norm, 1e-5 * norm);
    adam.step();
    takeStep({number, 0.01, gradient.norm(), 0.5, 0.25}, gradient, 2, network, moments, average);
    const torch::NoGradGuard no_gradient;
    for (size_t i = 0; i < peer->parameters().size(); ++i) {
      peer_average->parameters()[i].lerp_(peer->parameters()[i], 0.25);
      // a step is .01 long: rounding of its factors may move it by a few 1e-7 of that, and every step adds its own
      EXPECT_TRUE(torch::allclose(network->parameters()[i], peer->parameters()[i], 1e-5, 1e-7)) << "parameter " << i;
      EXPECT_TRUE(torch::allclose(average->parameters()[i], peer_average->parameters()[i], 1e-5, 1e-7)) << "average " << i;
    }
  }
}

TEST_F(Checkpoint, ResumesAKilledRunBitForBit) {
  TrainingState whole = freshState();
  trainUntil(whole, -1, "");
  TrainingState killed = freshState();
  trainUntil(killed, 20, path_);
  ASSERT_EQ(killed.step, 20);

  // another process knows nothing but the file: even theta0 comes from there
  TrainingState resumed = makeState(run().options, Theta(ThetaLayout::count));
  readCheckpoint(CheckpointFile(path_), kIdentity, &resumed);
  ASSERT_EQ(resumed.step, 20);
  EXPECT_EQ(resumed.log_csv, killed.log_csv);
  trainUntil(resumed, -1, "");
  EXPECT_EQ(resumed.step, 40);
  expectSame(whole.network->parameters(), resumed.network->parameters(), "network");
  expectSame(whole.network->buffers(), resumed.network->buffers(), "network's buffers");
  expectSame(whole.average->parameters(), resumed.average->parameters(), "average");
  EXPECT_EQ(whole.draw, resumed.draw);
  EXPECT_EQ(whole.recent_losses, resumed.recent_losses);
  EXPECT_EQ(heldOutError(whole.average, kTrainedKind, run().held_out, CheckOptions().loss(), 6).final,
            heldOutError(resumed.average, kTrainedKind, run().held_out, CheckOptions().loss(), 6).final);
}

TEST_F(Checkpoint, OfAnotherRunIsRefused) {
  writeFresh();
  EXPECT_FALSE(refused());
  for (const auto member : {&RunIdentity::representation, &RunIdentity::options_json, &RunIdentity::basis_sha256,
                            &RunIdentity::training_set_sha256}) {
    RunIdentity other = kIdentity;
    other.*member = "another";
    EXPECT_TRUE(refused(other)) << "instead of " << kIdentity.*member;
  }
}

TEST_F(Checkpoint, IsRefusedWhenDamaged) {
  writeFresh();
  const std::string whole = readFile(path_);
  const auto said = [&](const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    EXPECT_EQ(refused(), inputErrorOf([&] { CheckpointFile{path_}; }) != "no error");
    return refused() ? "refused" : "";
  };
  expectDamageIsRefused(whole, said, whole.size() / 23);
}

TEST(LossGuard, PutsBackTheStateThatItKept) {
  TrainingState state = freshState(), good = freshState();
  trainUntil(state, 20, "");
  trainUntil(good, 20, "");
  const LossGuard guard(state, 10);
  trainUntil(state, -1, "");
  ASSERT_EQ(state.step, 40);
  state.rollbacks = LossGuard::kMaxRollbacks;
  EXPECT_THROW(guard.rollBack(&state, "loss", NAN), NumericalError);
  EXPECT_EQ(state.step, 20) << "put back all the same";
  state.rollbacks = 0;
  guard.rollBack(&state, "loss", NAN);
  EXPECT_EQ(state.step, 20);
  EXPECT_EQ(state.draw, 40) << "the samples since then are not taken again";
  EXPECT_EQ(state.rollbacks, 1);
  EXPECT_EQ(state.recent_losses, good.recent_losses);
  expectSame(state.network->parameters(), good.network->parameters(), "network");
  expectSame(state.average->parameters(), good.average->parameters(), "average");
  // the moments too: the same samples lead both to the same place
  state.rollbacks = 0;
  state.draw = good.draw;
  trainUntil(state, -1, "");
  trainUntil(good, -1, "");
  expectSame(state.network->parameters(), good.network->parameters(), "network, steps later");
}

TEST(LossGuard, RefusesLossesFarAboveTheMedian) {
  TrainingState state = freshState();
  const LossGuard guard(state, 10);
  EXPECT_TRUE(guard.accepts(state, 1e6, 1.0)) << "nothing to compare with yet";
  for (int i = 0; i < 60; ++i) noteLoss(&state, 0.01 + 1e-4 * (i % 3));
  EXPECT_TRUE(guard.accepts(state, 0.1, 1.0));
  EXPECT_FALSE(guard.accepts(state, 0.102, 1.0)) << "the median is .0101";
  EXPECT_FALSE(guard.accepts(state, NAN, 1.0));
  EXPECT_FALSE(guard.accepts(state, 0.01, INFINITY));
}

TEST(FitTheta0, FitsTheMeanOfValidPoints) {
  // the mean is the tent where it is valid, and anything elsewhere: tent_mlp must come close to it
  BasisFile basis;
  for (int p = 0; p < kSupportPointCount; ++p) {
    const bool valid = p % 3 != 0;
    basis.mean_function.push_back(valid ? tent(supportPattern().points[p]) : 0.0f);
    basis.mean_validity.push_back(valid ? 0.5f : 0.0f);
  }
  StartOptions options;
  options.candidates = 4;
  options.candidate_steps = 100;
  options.finalists = 1;
  options.final_steps = 300;
  options.levenberg_iterations = 20;
  const Theta theta = fitTheta0(kTrainedKind, basis, options);
  // a quarter of the tent's own root mean square (1/3)^(3/2) = 0.19 would be a fit that has learnt; the masked zeros would cost
  // 0.11
  EXPECT_LT(functionRmse(kTrainedKind, tentFunction(), theta.data()), 0.25 * 0.19);
}

TEST(WorstFunctions, AreThoseOfTheLargestErrorWithWhatIsPredicted) {
  TrainOptions options = run().options;
  options.bare_tent_rmse = -1.0;
  options.shape.exact_last_layer = false;
  Theta bare(ThetaLayout::count);
  bare[ThetaLayout::b3] = 1.0f;
  TrainingState state = makeState(options, bare);
  const auto worst = worstFunctions(state.network, kTrainedKind, run().held_out, options, 100);
  ASSERT_EQ(worst.size(), 6u);
  double sum = 0.0, before = INFINITY;
  for (const WorstFunction& one : worst) {
    EXPECT_LE(one.blend_rmse, before);
    before = one.blend_rmse;
    sum += one.blend_rmse;
    EXPECT_GT(one.points.size(), 100u);
    for (const WorstFunction::Point& point : one.points) {
      // the tent, at most an eighth lower than in the plane itself
      const float tent = (1.0f - std::abs(point.u)) * (1.0f - std::abs(point.v));
      EXPECT_LE(point.predicted, tent + 1e-5f);
      EXPECT_GE(point.predicted, 0.87f * tent - 1e-5f);
    }
  }
  EXPECT_NEAR(sum / 6.0, heldOutError(state.network, kTrainedKind, run().held_out, options.loss, 6).network, 1e-6);
  EXPECT_EQ(worstFunctions(state.network, kTrainedKind, run().held_out, options, 2).size(), 2u);
}

}  // namespace
}  // namespace nlg
