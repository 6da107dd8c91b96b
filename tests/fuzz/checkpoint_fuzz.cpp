// Hostile checkpoints: whatever the bytes, they are refused in one line, or hold a run's counts and as many finite numbers as are
// asked for.
#include <cmath>

#include "tests/fuzz/digests.h"
#include "tests/fuzz/fuzz.h"
#include "train/generator/run/checkpoint_file.h"

namespace nlg::fuzz {
namespace {

const RunIdentity kIdentity = {"mlp", "{}", "basis", "set"};
const RunProgress kTrained = {
    .step = 1, .draw = 1, .rollbacks = 0, .recent_losses = {0.5, 0.25}, .log_csv = "step,loss\n1,0.5\n"};

NamedNumbers numbers() {
  NamedNumbers numbers;
  for (const char* role : {"network", "average", "adam.mean", "adam.square"}) {
    numbers[role + std::string(".layer0.weight")] = std::vector<float>(6, 0.25f);
    numbers[role + std::string(".layer0.bias")] = std::vector<float>(3, 0.5f);
  }
  return numbers;
}

void readAll(const std::string& path) {
  const CheckpointFile file(path);
  const RunProgress& progress = file.progress();
  FUZZ_CHECK(progress.step >= 0 && progress.draw >= 0 && progress.rollbacks >= 0, "counts");
  for (const double loss : progress.recent_losses) FUZZ_CHECK(std::isfinite(loss), std::to_string(loss));
  for (const auto& [name, expected] : numbers()) {
    const std::vector<float> got = file.numbers(name, expected.size());
    FUZZ_CHECK(got.size() == expected.size(), name);
    for (const float value : got) FUZZ_CHECK(std::isfinite(value), name);
  }
}

std::string bytesOf(const RunProgress& progress, const NamedNumbers& numbers) {
  const ScratchFile file("seed");
  writeCheckpointFile(file.path(), kIdentity, progress, numbers);
  return file.read();
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("run.ckpt");
  file.write(withRightDigest(std::string(bytes)));
  isTaken([] { readAll(file.path()); });
}

Seeds seeds() { return {{"fresh", bytesOf({}, {})}, {"trained", bytesOf(kTrained, numbers())}}; }

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
