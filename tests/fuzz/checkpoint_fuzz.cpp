// Hostile checkpoints: whatever the bytes, they are refused in one line, or become networks of the shape that was asked for.
//
// An input is an archive of libtorch's; the SHA-256 that stands before it is made here, or no mutation would get past it.
#include "tests/fuzz/fuzz.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tool/atomic_file.h"
#include "train/generator/checkpoint.h"

// libtorch loses some hundred bytes for each damaged archive that it refuses.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libtorch\nleak:libc10"; }

namespace nlg::fuzz {
namespace {

const RunIdentity kIdentity = {"mlp", "{}", "basis", "set"};
constexpr size_t kDigestSize = 64;

TrainingState freshState() {
  GeneratorShape shape;
  shape.coefficient_count = shape.width = 2;
  shape.layer_count = 1;
  shape.correction_steps = 0;
  const Theta theta0(3, 0.5f);
  TrainingState state;
  state.network = GeneratorNetwork(shape, theta0, 1);
  state.average = GeneratorNetwork(shape, theta0, 1);
  state.optimizer = std::make_shared<torch::optim::Adam>(state.network->parameters());
  return state;
}

std::string archiveOf(const TrainingState& state) {
  const ScratchFile file("seed");
  writeCheckpoint(file.path(), kIdentity, state);
  return file.read().substr(kDigestSize);
}

// A step of training, so that Adam has moments.
TrainingState trainedState() {
  TrainingState state = freshState();
  state.network->forward(torch::ones({1, 2})).sum().backward();
  state.optimizer->step();
  state.step = state.draw = 1;
  state.recent_losses = {0.5, 0.25};
  state.log_csv = "step,loss\n1,0.5\n";
  return state;
}

void checkSame(const std::vector<torch::Tensor>& got, const std::vector<torch::Tensor>& expected) {
  FUZZ_CHECK(got.size() == expected.size(), std::to_string(got.size()));
  for (size_t i = 0; i < got.size(); ++i) {
    FUZZ_CHECK(got[i].sizes() == expected[i].sizes(), "shape of tensor " + std::to_string(i));
    FUZZ_CHECK(got[i].dtype() == expected[i].dtype(), "type of tensor " + std::to_string(i));
    FUZZ_CHECK(got[i].sum().numel() == 1, "every number can be read");
  }
}

void readAll(const std::string& path) {
  readCheckpointHead(path);
  TrainingState state = freshState();
  readCheckpoint(path, kIdentity, &state);
  const TrainingState expected = freshState();
  checkSame(state.network->parameters(), expected.network->parameters());
  checkSame(state.network->buffers(), expected.network->buffers());
  checkSame(state.average->parameters(), expected.average->parameters());
  checkSame(state.average->buffers(), expected.average->buffers());
  std::vector<torch::Tensor> means, squares;
  for (const torch::optim::AdamParamState* moments : adamMoments(state)) {
    means.push_back(moments->exp_avg());
    squares.push_back(moments->exp_avg_sq());
  }
  if (means.empty()) return;
  checkSame(means, expected.network->parameters());
  checkSame(squares, expected.network->parameters());
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("run.ckpt");
  file.write(sha256(bytes) + std::string(bytes));
  isTaken([] { readAll(file.path()); });
}

Seeds seeds() { return {{"fresh", archiveOf(freshState())}, {"trained", archiveOf(trainedState())}}; }

std::string mutated(std::string bytes, size_t max_size, Random&) { return mutatedBlindly(std::move(bytes), max_size); }

}  // namespace nlg::fuzz
