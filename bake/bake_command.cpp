#include "bake/bake_command.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/again/check.h"
#include "bake/again/relight.h"
#include "bake/bake_plan.h"
#include "bake/load_generators.h"
#include "bake/report/bake_report.h"
#include "datagen/dataset/shard_file.h"
#include "nlg/simd.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/support/point_order.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/printable.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

constexpr uint64_t kMostCollected = 1200;  // functions, as in a shard of nlg-datagen

bool isSameFile(const std::string& a, const std::string& b) {
  const auto whole = [](const std::string& name) {
    std::error_code error;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(name), error);
  };
  return whole(a) == whole(b);
}

void checkOutput(const std::string& path, const OwnFiles& own, const char* flag, const std::vector<std::string>& inputs) {
  refuseToReplace(path, inputs, own, flag);
  requireOutputFile(path);
}

void warn(const PreparedScene& scene, const std::string& what) {
  std::cerr << "nlg-bake: " << scene.source.id << ": " << what << '\n';
}

void checkOut(const BakeRequest& request, const std::vector<std::string>& inputs) {
  checkOutput(request.out, kGridFiles, "--out", inputs);
  if (!request.json.empty() && request.json != "-" && isSameFile(request.json, request.out))
    throw UsageError("--json and --out name the same file: " + request.json);
}

// Empty where nothing is collected.
std::string collectedPath(const BakeRequest& request, const PreparedScene& scene) {
  if (request.collect.empty()) return {};
  return (std::filesystem::path(request.collect) / (scene.source.id + ".collected.h5")).string();
}

// Writes the functions as a shard like those of nlg-datagen, whose origin is that of the grid: it names the scene by its SHA-256.
void writeCollected(const std::string& path, const PreparedScene& scene, const BakeOptions& options, const GridMetadata& metadata,
                    FunctionRows functions) {
  Shard shard;
  static_cast<FunctionRows&>(shard) = std::move(functions);
  shard.scene_id = scene.source.id;
  shard.family = scene.source.family;
  shard.pattern_hash = supportPattern().hash;
  shard.test_pattern_hash = hashPoints({});
  shard.duplicate_rule = {options.duplicate_rms, static_cast<uint64_t>(options.duplicate_validity_points)};
  shard.provenance_json = metadata.at("provenance");
  shard.counts.grid_probes = scene.tree.probeCount();
  shard.counts.visited_probes = shard.counts.functions = shard.functionCount();
  for (const uint8_t flags : shard.flags) shard.counts.solid_functions += (flags & kFlagInSolid) != 0;
  writeShard(path, shard);
}

void runBake(BakeRequest request, const BakeOptions& options, const OptionTable& table) {
  const auto start = std::chrono::steady_clock::now();
  if (request.weights.empty()) request.weights = shippedWeights(options.representation, weightsFolders());
  // outputs and contradictions before any file is read: a bake takes minutes
  std::vector<std::string> inputs = request.weights;
  inputs.insert(inputs.end(), {request.scene, request.config});
  inputs.insert(inputs.end(), options.scene_light.sky.begin(), options.scene_light.sky.end());
  checkOutputs(request, inputs);
  if (!request.collect.empty()) requireOutputFolder(request.collect, "--collect");
  if (options.light == "none" && !options.scene_light.light_state.empty())
    throw UsageError("--light-state cannot be combined with --light none");
  if (options.light == "none" && (options.thin_error > 0.0 || options.max_bytes > 0.0))
    throw UsageError(std::string(options.thin_error > 0.0 ? "--thin-error" : "--max-bytes") +
                     " cannot be combined with --light none: thinning needs light");
  const auto [generators, paths, sha256] = loadGeneratorsOf(request);
  const PreparedScene scene = prepareScene(request, options, generators);
  const double load_s = secondsSince(start);
  if (!request.out_is_given) {
    request.out = scene.source.id + ".safetensors";
    checkOut(request, inputs);
  }
  const std::string collected = collectedPath(request, scene);
  if (!collected.empty()) checkOutput(collected, kShardFiles, "--collect", inputs);
  const GridMetadata metadata = bakeMetadata(scene, bakedOptions(table), sha256);
  Bake bake = bakeScene(scene, generators, options, temporaryFolder(), metadata, collected.empty() ? 0 : kMostCollected);

  BakeReport report;
  report.file_bytes = writeGrid(request, bake.grid, options, metadata);
  const uint64_t collected_count = bake.failed.functionCount();
  if (collected_count > 0) writeCollected(collected, scene, options, metadata, std::move(bake.failed));
  report.scene = scene.source.id;
  report.notes = scene.source.notes.size();
  std::vector<uint64_t> weights_bytes;
  for (size_t g = 0; g < generators.size(); ++g) {
    const std::string representation(representationName(generators[g].representation()));
    weights_bytes.push_back(std::filesystem::file_size(paths[g]));
    report.weights.push_back({representation, sha256.at(kWeightsRole + representation), weights_bytes.back()});
  }
  report.threads = threadsOf(options);
  // savings read the statistics, which the report then takes over
  const GridPrecision stored{options.policy.theta_precision, options.light_error};
  report.savings = savingsOf(bake, generators, options.policy, stored, weights_bytes, report.threads);
  report.statistics = std::move(bake.statistics);
  report.statistics.load_wall_s = load_s;
  report.policy = options.policy;
  report.theta_bytes = lightGridBytes(bake.grid, {stored.theta, {}}).theta;  // light would be coded for nothing
  report.peak_memory_bytes = peakMemoryBytes();
  report.simd = chosenSimdTarget();
  if (report.statistics.counts.functions + report.statistics.bare_tents.count == 0)
    warn(scene,
         "no probe has a weighting function; check that extent_m covers the scene, and that spacing_m is smaller than its rooms");
  warnOfLight(scene, options, report.statistics.light);
  std::cerr << toSummary(report, request.out);
  if (!collected.empty()) {
    const uint64_t failing = report.statistics.failing(ThetaWord::stored, report.policy.check());
    std::cerr << collected
              << (failing == 0
                      ? ": not written, because no function fails the check\n"
                      : fmt::format(": {} of the {} that fail the check\n", collected_count, countText(failing, "function")));
  }
  writeJson(request, toJson(report));
}

}  // namespace

void checkOutputs(const BakeRequest& request, const std::vector<std::string>& inputs) {
  if (!request.json.empty() && request.json != "-") checkOutput(request.json, kReportFiles, "--json", inputs);
  if (request.out_is_given) checkOut(request, inputs);
}

NamedGenerators loadGeneratorsOf(const BakeRequest& request) {
  auto [generators, paths] = loadGenerators(request.weights);
  NamedGenerators named{std::move(generators), std::move(paths), {}};
  for (size_t g = 0; g < named.paths.size(); ++g)
    named.sha256[kWeightsRole + std::string(representationName(named.generators[g].representation()))] =
        fileSha256(named.paths[g]);
  return named;
}

PreparedScene prepareScene(const BakeRequest& request, const BakeOptions& options, const std::vector<Generator>& generators,
                           const KnownAir& known) {
  SceneSource source = loadLitScene(request.scene, options);
  // before its probes are placed: they may say why there are too many
  tellNotes("nlg-bake", source);
  tellLightNotes(source);
  return {std::move(source), options, known, [&](const PlacedScene& placed) {
            for (const std::string& path : request.weights) std::cerr << "weights: " << path << '\n';
            std::cerr << toText(planBake(placed, options, generators), placed, options);
          }};
}

uint64_t writeGrid(const BakeRequest& request, const LightGrid& grid, const BakeOptions& options, const GridMetadata& metadata) {
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, {options.policy.theta_precision, options.light_error}, metadata, &bytes);
  if (!result.ok()) throw NumericalError("bake: light grid: " + result.detail + ": a number that the file cannot hold");
  NLG_CHECK(options.max_bytes == 0.0 || static_cast<double>(bytes.size()) <= options.max_bytes, ==, true);
  writeFileAtomically(request.out, bytes);
  return bytes.size();
}

void warnOfLight(const PreparedScene& scene, const BakeOptions& options, const LightStatistics& statistics) {
  for (const std::string& warning : lightWarnings(statistics)) warn(scene, warning);
  const SceneLight& light = scene.source.scene.light;
  if (options.light_direct != "all" && options.light_direct != "reflected" && light.lamps.empty() && light.suns.empty())
    warn(scene, "light_direct leaves nothing out: the scene has no lamps and no suns of its own");
}

void writeJson(const BakeRequest& request, const nlohmann::ordered_json& json) {
  // a name that the level's file brings may be no UTF-8
  const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  if (request.json == "-") {
    std::cout << text;
  } else if (!request.json.empty()) {
    writeFileAtomically(request.json, text);
  }
}

// Not by getrusage: that begins with what the program had that started this one, Blender say.
uint64_t peakMemoryBytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  uint64_t kib = 0;
  while (status >> word) {
    if (word == "VmHWM:" && status >> kib) return kib * 1024;
  }
  return 0;
}

void runBakeCommand(const BakeRequest& request, const BakeOptions& options, const OptionTable& table) {
  for (const auto& [is_given, flag] : {std::pair(options.draft, "--draft"), std::pair(!request.checked.empty(), "--check"),
                                       std::pair(!request.relit.empty(), "--relight")}) {
    if (is_given && !request.collect.empty())
      throw UsageError(std::string("--collect cannot be combined with ") + flag + ": no function is checked");
  }
  if (!request.inputs.empty()) {
    std::vector<std::string> others = request.weights;
    others.insert(others.end(), {request.scene, request.config, request.relit, request.checked, request.out, request.json});
    checkOutput(request.inputs, kInputsFiles, "--inputs", others);
  }
  const auto run = !request.checked.empty() ? runCheck : !request.relit.empty() ? runRelight : runBake;
  const auto writeInputs = [&] {
    if (!request.inputs.empty()) writeFileAtomically(request.inputs, inputsText(inputsSoFar()));
  };
  try {
    run(request, options, table);
  } catch (const std::exception&) {
    writeInputs();
    throw;
  }
  writeInputs();
}

}  // namespace nlg
