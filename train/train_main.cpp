// nlg-train: trains the generator of one representation; a killed run goes on where its last checkpoint stood.

#include <torch/cuda.h>
#include <cstring>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "train/generator/data/function_cache.h"
#include "train/generator/network/code_ordering.h"
#include "train/generator/run/checkpoint.h"
#include "train/generator/run/trainer.h"
#include "train/generator/run/worst_functions.h"
#include "train/torch_threads.h"

namespace nlg {
namespace {

constexpr size_t kPictured = 4;  // held-out functions, after every validation

struct Request {
  std::string representation, basis, cache, out, run, log, init;
  std::vector<std::string> shards, held_out;
  std::string device = "cpu";
  ProcessGroup::Options processes;
  bool restart_on_change = false;
};

// srun tells every process its number, and how many they are.
void readSlurm(ProcessGroup::Options& processes, bool is_given) {
  const char* rank = std::getenv("SLURM_PROCID");
  const char* count = std::getenv("SLURM_NTASKS");
  if (is_given || processes.rendezvous.empty() || rank == nullptr || count == nullptr) return;
  const int asked = processes.count;
  processes.rank = std::atoi(rank);
  processes.count = std::atoi(count);
  if (asked == 1 || asked == processes.count) return;
  throw UsageError("processes", std::to_string(processes.count) + ", which srun started", std::to_string(asked));
}

// What makes a run the run that it is, and goes with its weights. Threads change no bit, and processes none but by rounding: a run may go on with others.
nlohmann::ordered_json runOptions(const Request& request, const OptionTable& table, const TrainingData& training,
                                  const TrainingData& held_out, const Scenes& seen) {
  nlohmann::ordered_json options = table.toJson();
  options.erase("processes");
  options.erase("threads");
  options["held_out_sha256"] = held_out.sha256();  // by which the curve judges
  options["training_functions"] = training.functionCount();
  options["training_scenes"] = seen;
  if (!request.init.empty()) options["init_sha256"] = fileSha256(request.init);
  return options;
}

void check(const Request& request, const TrainOptions& options) {
  const auto require = [](bool holds, const char* place, const std::string& expected, const std::string& got) {
    if (!holds) throw UsageError(place, expected, got);
  };
  const ProcessGroup::Options& processes = request.processes;
  require(request.shards.empty() != request.cache.empty(), "--cache", "either --shards or --cache",
          request.cache.empty() ? "neither" : "both");
  require(processes.count >= 1 && processes.rank >= 0 && processes.rank < processes.count, "--rank",
          "a number from 0 to --processes - 1", std::to_string(processes.rank) + " of " + std::to_string(processes.count));
  require(processes.count == 1 || !processes.rendezvous.empty(), "--rendezvous", "a file through which the processes meet",
          "none");
  require((options.point_batches & (options.point_batches - 1)) == 0, "point_batches", "1, 2, 4 or 8",
          std::to_string(options.point_batches));
  require(options.shape.dictionary_resolution % 2 == 1, "dictionary_resolution", "3, 5, 7 or 9",
          std::to_string(options.shape.dictionary_resolution));
  require(processes.count <= options.batch, "processes", "at most batch", std::to_string(processes.count));
}

torch::Device findDevice(const std::string& name) {
  if (name == "cpu") return torch::kCPU;
  if (name != "cuda") throw UsageError("--device", "cpu or cuda", "'" + name + "'");
  if (!torch::cuda::is_available()) throw UsageError("--device", "cpu, since libtorch finds no CUDA device", "cuda");
  return torch::kCUDA;
}

// The generator that training begins with: its shape, and coefficients as it knows them, go over the options.
// seen   gets the scenes that it was trained on
std::optional<GeneratorData> readInit(const Request& request, Representation* representation, TrainOptions* options,
                                      Scenes* seen) {
  if (request.init.empty()) return {};
  WeightsFile file;
  GeneratorData data;
  requireRead(request.init, readWeightsFile(request.init, &file), "the weights of a generator");
  requireRead(request.init, generatorFromWeights(file, &data), "the weights of a generator");
  if (representationName(data.representation) != request.representation)
    throw InputError(request.init, "representation", request.representation, representationName(data.representation));
  try {
    *seen = nlohmann::json::parse(file.metadata["training_options"]).at("training_scenes").get<Scenes>();
  } catch (const nlohmann::json::exception&) {
    std::cerr << "nlg-train: " << request.init
              << " does not say which scenes it was trained on: held-out ones may be among them\n";
  }
  options->shape = shapeOf(data, options->shape);
  options->representation_slope = representation->slope = data.representation.slope;
  options->whitening = 1.0;
  const bool reads_samples = data.basis.input == GeneratorInput::samples;
  options->input = reads_samples ? "samples" : "coefficients";
  options->coefficients = reads_samples ? data.basis.coefficientCount() : 0;
  options->begins_trained = true;
  return data;
}

// The first layer reads coefficients of its own basis alone; components of samples travel with it.
void requireBasisOf(const GeneratorData& init, const BasisData& used, const Request& request) {
  const BasisData& own = init.basis;
  if (own.input == GeneratorInput::samples) return;
  if (own.class_count == used.class_count && own.mean == used.mean && own.components == used.components &&
      own.deviation == used.deviation)
    return;
  throw InputError(request.basis, "basis", "the basis of " + request.init + " (nlg-pca --from " + request.init + ")",
                   "another basis");
}

// used   the basis, or as much of it as the options say
TrainingData readTrainingData(const Request& request, const BasisFile& basis, const BasisData& used) {
  if (request.cache.empty()) {
    FunctionSet set = readFunctionSet(request.shards, supportPattern().hash, kSupportPointCount);
    if (set.functionCount() == 0) throw InputError(request.shards.front(), "functions", "at least one in all shards", "none");
    return TrainingData(std::move(set), basis.basis.data, used, FunctionOrder::cache);
  }
  endWhenPagesVanish("nlg-train", request.cache);
  auto cache = std::make_unique<FunctionCache>(request.cache);
  const std::string basis_sha256 = fileSha256(request.basis);
  if (cache->origin().basis_sha256 != basis_sha256) {
    throw InputError(request.cache, "basis", "a cache made with " + request.basis + ", " + basis_sha256,
                     cache->origin().basis_sha256);
  }
  return TrainingData(std::move(cache), basis.basis.data, used);
}

// Whether a run is the one that is asked for but for its number of steps, of which more are asked for.
bool isExtended(const RunIdentity& found, const RunIdentity& asked) {
  nlohmann::ordered_json a = nlohmann::ordered_json::parse(found.options_json, nullptr, false),
                         b = nlohmann::ordered_json::parse(asked.options_json, nullptr, false);
  if (!a.is_object() || !b.is_object() || !a.contains("steps") || !b.contains("steps") || !(a["steps"] < b["steps"]))
    return false;
  a.erase("steps"), b.erase("steps");
  RunIdentity same = found;
  same.options_json = asked.options_json;
  return a == b && same == asked;
}

// Goes on from the run's newest whole checkpoint when there is one of this very run, or of a shorter one.
void resume(const Request& request, const RunIdentity& identity, const RunFolder& folder, TrainingState* state) {
  const std::vector<std::string> paths = folder.newestFirst();
  for (const std::string& path : paths) {
    std::optional<CheckpointFile> file;
    try {
      file.emplace(path);
    } catch (const InputError& error) {
      // a damaged file says nothing of the run: the one before it may be whole
      if (path == paths.back() && !request.restart_on_change) throw;
      std::cerr << "nlg-train: left out: " << error.what() << '\n';
      continue;
    }
    if (file->identity() != identity && request.restart_on_change) {
      std::cerr << "nlg-train: starting afresh: " << path << " is of another run\n";
      break;
    }
    // more steps of the same run go on from its checkpoint
    const bool is_extended = isExtended(file->identity(), identity);
    readCheckpoint(*file, is_extended ? file->identity() : identity, state);
    if (is_extended)
      std::cerr << "nlg-train: an extended run: its learning rate rises again, so that it ends otherwise than a run begun with "
                   "this many steps\n"
                   "";
    std::cerr << "nlg-train: going on from step " << state->step << " of " << path << '\n';
    if (request.processes.rank == 0) folder.settle(path, *state);
    return;
  }
  // what another run left must not mix with this one
  if (!paths.empty() && request.processes.rank == 0) folder.clear();
}

// Processes that do not train the same run would leave a checkpoint that is of none.
void requireSameRun(const ProcessGroup& processes, const RunIdentity& identity) {
  if (processes.count() == 1) return;
  constexpr int kParts = 4, kDigits = 8;  // of the digest: each part is exact as a double
  const std::string digest = sha256(identity.representation + '\n' + identity.options_json + '\n' + identity.basis_sha256 + '\n' +
                                    identity.training_set_sha256);
  torch::Tensor digests = torch::zeros({processes.count(), kParts}, torch::kDouble);
  for (int part = 0; part < kParts; ++part) {
    digests[processes.rank()][part] = static_cast<double>(std::stoul(digest.substr(part * kDigits, kDigits), nullptr, 16));
  }
  processes.sum(digests);
  for (int rank = 0; rank < processes.count(); ++rank) {
    if (torch::equal(digests[rank], digests[processes.rank()])) continue;
    throw InputError("--rank", "process " + std::to_string(rank),
                     "the representation, options, basis and training set of process " + std::to_string(processes.rank()),
                     "other ones");
  }
}

// A basis of other functions may serve, as that of --init does; but one that was fitted to held-out functions has seen them.
void warnOfOtherFunctions(const BasisFile& basis, const TrainingData& training, const std::string& path) {
  const nlohmann::ordered_json origin = parsedOrText(basis.provenance_json);
  const nlohmann::ordered_json inputs =
      origin.is_object() ? origin.value("inputs", nlohmann::ordered_json()) : nlohmann::ordered_json();
  const auto fitted_to = inputs.find("training_set");
  if (fitted_to == inputs.end() || *fitted_to == training.sha256()) return;
  std::cerr << "nlg-train: " << path << " was fitted to other functions than the training set's\n";
}

// Whole scenes are held out, or the held-out error would say nothing; a copy under another name is the same scene.
void requireSeparate(const Request& request, const Scenes& seen, const Scenes& held_out) {
  const auto [scene, other] = seenScene(seen, held_out);
  if (scene.empty()) return;
  throw InputError(request.held_out.size() == 1 ? request.held_out.front() : "--held-out", "scene " + scene,
                   "a scene that neither training shards nor --init were trained on", "the training scene " + other);
}

void printReport(const Request& request, const TrainingData& training, const TrainingState& state, const TrainReport& report) {
  const nlohmann::ordered_json result = {{"representation", request.representation},
                                         {"functions", training.functionCount()},
                                         {"steps", state.step},
                                         {"held_out_network_blend_rmse", report.held_out.network},
                                         {"held_out_blend_rmse", report.held_out.final},
                                         {"bare_tent_blend_rmse", report.held_out.tent},
                                         {"rollbacks", state.rollbacks},
                                         {"elapsed_s", report.elapsed_s},
                                         {"samples_per_s", report.samples_per_s}};
  std::cout << result.dump() << '\n';
}

// options   that the table describes: what an initial generator says of them goes over them, and into every record of the run
void run(const Request& request, TrainOptions& options, const OptionTable& table) {
  check(request, options);
  std::vector<std::string> inputs = request.shards;
  inputs.insert(inputs.end(), request.held_out.begin(), request.held_out.end());
  inputs.push_back(request.basis);
  for (const std::string& input : {request.cache, request.init}) {
    if (!input.empty()) inputs.push_back(input);
  }
  refuseToReplace(request.out, inputs, kCheckpointFiles);
  refuseToReplace(
      request.log, inputs,
      {"a curve of nlg-train", [](std::string_view bytes) { return bytes.starts_with("step,learning_rate,training_loss,"); }},
      "--log");
  Representation representation;
  if (!findRepresentation(request.representation, &representation)) {
    throw UsageError("--representation", representationNames(), "'" + request.representation + "'");
  }
  representation.slope = static_cast<float>(options.representation_slope);
  Scenes seen;
  const std::optional<GeneratorData> init = readInit(request, &representation, &options, &seen);
  options.device = findDevice(request.device);
  computeOnCallingThreads();
  // a system that refuses threads is found before any data are read
  requireThreads(options.threads - 1 + (request.cache.empty() ? 0 : 1));  // one that reads the cache
  const BasisFile basis = readBasisFile(request.basis);
  if (const int most = basis.basis.data.coefficientCount(); options.input != "samples" && options.coefficients > most) {
    throw UsageError("coefficients", "at most the " + std::to_string(most) + " of the basis",
                     std::to_string(options.coefficients));
  }
  // the basis as the generator reads it: cut to the coefficients that are asked for, and whitened
  const BasisData used = usedBasis(options, basis.basis);
  // of samples as many of each of the eight parities
  if (const int asked = options.coefficients > 0 ? options.coefficients : basis.basis.data.coefficientCount();
      used.coefficientCount() < asked)
    std::cerr << "nlg-train: " << used.coefficientCount() << " of " << asked << " components: a multiple of 8\n";
  options.shape.input = used.input;
  options.shape.coefficient_count = used.coefficientCount();
  options.shape.code_count = representation.code_count;
  if (init) requireBasisOf(*init, used, request);
  const TrainingData training = readTrainingData(request, basis, used);
  const TrainingData held_out(readFunctionSet(request.held_out, supportPattern().hash, kSupportPointCount), basis.basis.data,
                              used);
  if (held_out.functionCount() == 0)
    throw InputError(request.held_out.front(), "functions", "at least one in all shards", "none");
  seen.insert(training.scenes().begin(), training.scenes().end());
  requireSeparate(request, seen, held_out.scenes());

  warnOfOtherFunctions(basis, training, request.basis);

  // a run is what its checkpoints say: it goes on from the newest whole one of the same options and data
  const RunIdentity identity{request.representation, runOptions(request, table, training, held_out, seen).dump(),
                             fileSha256(request.basis), training.sha256()};
  const RunFolder folder(request.run);
  const auto lock = request.processes.rank == 0 ? folder.lock() : nullptr;
  TrainingState state = makeState(options, Theta(representation.thetaCount()));
  resume(request, identity, folder, &state);
  // numbers to begin with are for a run that has none yet
  if (state.step == 0 && init) {
    for (GeneratorNetwork* network : {&state.network, &state.average}) (*network)->takeNumbers(*init);
  } else if (state.step == 0) {
    const Progress progress("theta0, where all functions begin");
    state = makeState(options, fitTheta0(representation, basis, options.start));
  }
  const auto save = [&] {
    // before the checkpoint: a run that is killed between them makes it again
    writeFileAtomically(
        fmt::format("{}/worst-{:09}.json", request.run, state.step),
        worstFunctionsJson(state.step, worstFunctions(state.average, representation, held_out, options, kPictured)).dump());
    folder.writeOrigin(table.toJson(),
                       provenance("nlg-train", table.toJson(),
                                  {{"training_set", identity.training_set_sha256}, {"basis", identity.basis_sha256}}));
    folder.save(identity, state);
    writeFileAtomically(request.log, state.log_csv);
  };
  const ProcessGroup processes(request.processes);
  requireSameRun(processes, identity);
  const TrainReport report = train(options, representation, training, held_out, &state, save, processes);
  if (processes.rank() != 0) return;
  // an exact last layer makes something of any network
  if (report.held_out.network >= report.held_out.tent) {
    std::cerr << "nlg-train: a network that is worse than the bare tent on held-out functions: " << report.held_out.network
              << ", " << report.held_out.tent << "; try a smaller learning_rate or more steps\n";
  }
  // numbers of codes in the order of what they add, scaled to bytes: the averaged network is what is exported
  if (representation.isCode()) {
    orderCodes(training, used, {.tent_rmse = options.bare_tent_rmse, .loss = options.loss, .threads = options.threads},
               &state.average);
  }
  writeFileAtomically(request.log, state.log_csv);
  writeCheckpoint(request.out, identity, state);
  printReport(request, training, state, report);
}

nlohmann::ordered_json describeCheckpoint(const std::string& path) {
  const CheckpointFile file(path);
  return {{"representation", file.identity().representation},
          {"steps", file.progress().step},
          {"rollbacks", file.progress().rollbacks},
          {"basis_sha256", file.identity().basis_sha256},
          {"training_set_sha256", file.identity().training_set_sha256},
          {"options", parsedOrText(file.identity().options_json)},
          {"verified", kVerifiedByDigest}};
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "info") == 0)
    return nlg::fileInfoMain(argc - 1, argv + 1, {"nlg-train info", "checkpoints (.ckpt)", "train", nlg::describeCheckpoint});
  CLI::App app{
      "Trains the generator network of one representation.\n"
      "nlg-train info FILE ...: verifies and describes checkpoints.",
      "nlg-train"};
  nlg::Request request;
  nlg::TrainOptions options;
  nlg::OptionTable table("train");
  nlg::describeTrainOptions(options, table);
  table.group("Run");
  table.common({"shards", "cache", "out", "run", "steps"});
  app.add_option("--representation", request.representation, nlg::representationNames())->required();
  app.add_option("--shards", request.shards, "training shards, read into memory");
  app.add_option("--cache", request.cache, "training set of nlg-cache, read from disk");
  app.add_option("--held-out", request.held_out, "shards of held-out scenes, for the validation loss")->required();
  app.add_option("--basis", request.basis, "basis of nlg-pca")->required();
  app.add_option("--out", request.out, "finished checkpoint to write")->required();
  app.add_option("--run", request.run, "folder of the run: checkpoints, curve and origin. A killed run resumes from it")
      ->required();
  app.add_option("--log", request.log, "training curve to write (.csv)")->required();
  app.add_option(
      "--init", request.init,
      "weights from which training starts (.safetensors), of the same basis (nlg-pca --from). Their shape overrides the options");
  app.add_option("--device", request.device, "device of the network: cpu or cuda");
  CLI::Option* rank = app.add_option("--rank", request.processes.rank, "rank of this process among those that train together");
  table.add("processes", &request.processes.count, "number of processes that train together; each takes its part of a batch", 1,
            4096);
  app.add_option("--rendezvous", request.processes.rendezvous,
                 "new file on storage that all processes can write, through which they meet. With it, srun's variables replace "
                 "--rank and --processes");
  app.add_option("--timeout-s", request.processes.timeout_s, "maximum wait for another process, seconds");
  app.add_flag("--restart-on-change", request.restart_on_change,
               "start a new run if --run holds another one, instead of refusing");
  return nlg::runTool(argc, argv, app, table, [&] {
    nlg::readSlurm(request.processes, rank->count() > 0);
    nlg::run(request, options, table);
  });
}
