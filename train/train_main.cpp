// nlg-train: trains the generator of one representation; a killed run goes on where its last checkpoint stood.

#include <ATen/Parallel.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/tool_main.h"
#include "train/generator/trainer.h"

namespace nlg {
namespace {

struct Request {
  std::string representation, basis, out, state, log;
  std::vector<std::string> shards, held_out;
  bool restart_on_change = false;
};

// Goes on from the state file when there is one of this very run.
void resume(const Request& request, const RunIdentity& identity, TrainingState* state) {
  if (!std::filesystem::exists(request.state)) return;
  try {
    readCheckpoint(request.state, identity, state);
    std::cerr << "nlg-train: going on from step " << state->step << " of " << request.state << '\n';
  } catch (const InputError& error) {
    if (!request.restart_on_change) throw;
    std::cerr << "nlg-train: starting afresh: " << error.what() << '\n';
  }
}

// Whole scenes are held out, or the held-out error would say nothing.
void requireSeparate(const Request& request, const FunctionSet& training, const FunctionSet& held_out) {
  for (const std::string& scene : held_out.scene_ids) {
    if (std::find(training.scene_ids.begin(), training.scene_ids.end(), scene) == training.scene_ids.end()) continue;
    throw InputError(request.held_out.front(), "scene " + scene, "scenes that no training shard holds", "one that is trained on");
  }
}

void run(const Request& request, TrainOptions options, const OptionTable& table) {
  Representation representation;
  if (!findRepresentation(request.representation, &representation)) {
    throw UsageError("--representation", representationNames(), "'" + request.representation + "'");
  }
  representation.slope = static_cast<float>(options.representation_slope);
  at::set_num_threads(options.threads);
  const BasisFile basis = readBasisFile(request.basis);
  options.shape.coefficient_count = basis.basis.data.coefficientCount();
  const TrainingData training(readFunctionSet(request.shards, supportPattern().hash, kSupportPointCount), basis.basis.data);
  const TrainingData held_out(readFunctionSet(request.held_out, supportPattern().hash, kSupportPointCount), basis.basis.data);
  if (training.functionCount() == 0) throw InputError(request.shards.front(), "functions", "at least one in all shards", "none");
  if (held_out.functionCount() == 0)
    throw InputError(request.held_out.front(), "functions", "at least one in all shards", "none");
  requireSeparate(request, training.set(), held_out.set());

  const RunIdentity identity{request.representation, table.toJson().dump(), fileSha256(request.basis), training.set().sha256};
  TrainingState state = makeState(options, Theta(representation.thetaCount()));
  resume(request, identity, &state);
  if (state.step == 0) state = makeState(options, fitTheta0(representation, basis, options.start));
  const TrainReport report = train(options, representation, training, held_out, &state, [&] {
    writeCheckpoint(request.state, identity, state);
    writeFileAtomically(request.log, state.log_csv);
  });
  writeFileAtomically(request.log, state.log_csv);
  writeCheckpoint(request.out, identity, state);
  std::error_code ignored;
  std::filesystem::remove(request.state, ignored);
  const nlohmann::ordered_json result = {{"representation", request.representation},
                                         {"functions", training.functionCount()},
                                         {"steps", state.step},
                                         {"held_out_rmse", report.held_out_rmse},
                                         {"elapsed_s", report.elapsed_s},
                                         {"samples_per_s", report.samples_per_s}};
  std::cout << result.dump() << '\n';
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  CLI::App app{"Trains the generator network of one representation.", "nlg-train"};
  nlg::Request request;
  nlg::TrainOptions options;
  nlg::OptionTable table("train");
  nlg::describeTrainOptions(options, table);
  app.add_option("--representation", request.representation, nlg::representationNames())->required();
  app.add_option("--shards", request.shards, "training shards")->required();
  app.add_option("--held-out", request.held_out, "shards of held-out scenes, for the validation loss")->required();
  app.add_option("--basis", request.basis, "the basis of nlg-pca")->required();
  app.add_option("--out", request.out, "the finished checkpoint to write")->required();
  app.add_option("--state", request.state, "where checkpoints go meanwhile; a killed run goes on from it")->required();
  app.add_option("--log", request.log, "the training curve to write (.csv)")->required();
  app.add_flag("--restart-on-change", request.restart_on_change,
               "start afresh, instead of refusing, when --state is of another run");
  return nlg::runTool(argc, argv, app, table, [&] { nlg::run(request, options, table); });
}
