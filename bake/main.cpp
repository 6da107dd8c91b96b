// nlg-bake: one scene and trained generators → a light grid of weighting functions.

#include <cstring>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "bake/again/bake_provenance.h"
#include "bake/again/own_files.h"
#include "bake/again/relight.h"
#include "bake/bake_plan.h"
#include "bake/load_generators.h"
#include "bake/policy_options.h"
#include "bake/probe_list.h"
#include "bake/report/bake_report.h"
#include "nlg/simd.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "scene/lights/light_sets.h"
#include "tool/atomic_file.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"

namespace nlg {
namespace {

struct Request {
  std::string scene, out, config, json;
  std::string inputs;   // a file to name all others in that were read
  std::string relit;    // a grid whose light is made anew; empty: everything is
  std::string checked;  // a grid that is only asked whether it is what would be baked
  std::vector<std::string> weights;
  bool out_is_given = false, is_verbose = false;
};

void chooseSimd(const std::string& name) {
  // the variable first, whatever the option says: later Generator::load would read it and override the option
  const SimdStatus inherited = forceSimdTargetFromEnvironment();
  if (inherited != SimdStatus::ok) {
    const char* variable = std::getenv("NLG_SIMD");
    throw UsageError("NLG_SIMD", "a SIMD target of this machine", simdRefusal(variable ? variable : "", inherited));
  }
  if (name.empty()) return;
  const SimdStatus status = forceSimdTarget(name);
  if (status != SimdStatus::ok) throw UsageError("--simd", "a SIMD target of this machine", simdRefusal(name, status));
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

// What a bake may come to without an error, and is seldom what was meant.
void warn(const PreparedScene& scene, const std::string& what) {
  std::cerr << "nlg-bake: " << scene.source.id << ": " << what << '\n';
}

void warnOfDarkness(const PreparedScene& scene, const BakeOptions& options, const LightStatistics& statistics) {
  for (const std::string& warning : lightWarnings(statistics)) warn(scene, warning);
  const std::vector<const Scene*> lit = litScenes(scene.source);
  const bool has_own =
      std::any_of(lit.begin(), lit.end(), [](const Scene* set) { return !set->light.lamps.empty() || !set->light.suns.empty(); });
  if (options.light_direct != "all" && options.light_direct != "reflected" && !has_own)
    warn(scene, "light_direct leaves nothing out: the scene has no lamps and no suns of its own");
}

void warnOfNothing(const PreparedScene& scene, const BakeOptions& options, const BakeStatistics& statistics) {
  if (statistics.counts.functions + statistics.bare_tents.count == 0)
    warn(scene,
         "no probe has a weighting function; check that extent_m covers the scene, and that spacing_m is smaller than its rooms");
  warnOfDarkness(scene, options, statistics.light);
}

// path   "-": stdout; empty: nowhere
void writeJson(const std::string& path, const nlohmann::ordered_json& json) {
  // a name that the level's file brings may be no UTF-8
  const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  if (path == "-") {
    std::cout << text;
  } else if (!path.empty()) {
    writeFileAtomically(path, text);
  }
}

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

// Before anything is read: a bake takes minutes.
void checkOutputs(const Request& request, const std::vector<std::string>& inputs) {
  if (request.out_is_given) checkOutput(request.out, kGridFiles, "--out", inputs);
  if (!request.json.empty() && request.json != "-") {
    checkOutput(request.json, kReportFiles, "--json", inputs);
    if (request.out_is_given && isSameFile(request.json, request.out)) throw UsageError("--json and --out name the same file: " + request.json);
  }
}

void chooseOut(const PreparedScene& scene, const std::vector<std::string>& inputs, Request* request) {
  if (!request->out_is_given) {
    request->out = scene.source.id + ".safetensors";
    checkOutput(request->out, kGridFiles, "--out", inputs);
  }
}

// generators   of the functions that will be made; none: light alone is
PreparedScene readScene(const Request& request, const BakeOptions& options, const std::vector<Generator>& generators, int threads,
                        const KnownAir& known = {}) {
  SceneSource source = loadLitScene(request.scene, options);
  try {
    std::cerr << toText(planBake(source, options, generators, threads), threads);
  } catch (const ToolError&) {
    // they may say what is wrong with it
    tellNotes("nlg-bake", source);
    throw;
  }
  for (const std::string& path : request.weights) std::cerr << "weights: " << path << '\n';
  tellNotes("nlg-bake", source);
  for (const std::string& note : source.light_notes) std::cerr << "light: " << note << '\n';
  return {std::move(source), options, known};
}

std::string fileBytes(const LightGrid& grid, const BakeOptions& options, const GridMetadata& metadata) {
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, {options.policy.theta_precision, options.light_error}, metadata, &bytes);
  if (!result.ok()) throw NumericalError("bake: light grid: " + result.detail + ": a number that the file cannot hold");
  NLG_CHECK(options.max_bytes == 0.0 || static_cast<double>(bytes.size()) <= options.max_bytes, ==, true);
  return bytes;
}

// Whether a grid is what this command line would bake.
void runCheck(Request request, const BakeOptions& options, const OptionTable& table) {
  for (const auto& [is_given, what] :
       {std::pair(!request.relit.empty(), "--relight"), std::pair(request.out_is_given, "--out")}) {
    if (is_given) throw UsageError(std::string("--check cannot be combined with ") + what + ": nothing is baked");
  }
  checkOutputs(request, {request.scene, request.config, request.checked});
  const BakedGrid baked = readBakedGrid(request.checked);
  if (request.weights.empty()) request.weights = shippedWeights(options.representation, weightsFolders(options.draft));
  std::map<std::string, std::string> weights;
  const auto [generators, weight_files] = loadGenerators(request.weights);
  for (size_t g = 0; g < generators.size(); ++g)
    weights[kWeightsRole + std::string(representationName(generators[g].representation()))] = fileSha256(weight_files[g]);
  SceneSource source = loadLitScene(request.scene, options);
  std::vector<std::string> changes = changesSince(request.checked, baked, source, table, weights);
  // other lamps may move probes: the scene is set up to see where they would stand
  if (changes == std::vector<std::string>{kLightChanged} &&
      !standsWhere({std::move(source), options, knownAir(request.checked, baked)}, baked))
    changes.push_back("probes would stand elsewhere");
  writeJson(request.json, {{"schema_version", 1}, {"grid", request.checked}, {"changes", changes}});
  if (request.json != "-") {
    if (changes.empty()) std::cout << request.checked << ": fresh\n";
    for (const std::string& change : changes) std::cout << request.checked << ": " << change << '\n';
  }
  if (!changes.empty()) throw ToolError(ExitCode::check_failed, request.checked + ": out of date");
}

// Light alone, for a grid whose functions stay.
void runRelight(Request request, const BakeOptions& options, const OptionTable& table) {
  std::vector<std::string> inputs = filesOfLight(options.light_set, options.scene_light);
  inputs.insert(inputs.end(), {request.scene, request.config, request.relit});
  checkOutputs(request, inputs);
  if (!request.weights.empty())
    throw UsageError("--relight cannot be combined with --weights: it reuses the functions of the grid");
  if (options.light == "none") throw UsageError("--relight cannot be combined with --light none: it computes light only");
  if (!request.out_is_given) throw UsageError("--relight needs --out: the grid to write");
  const auto start = std::chrono::steady_clock::now();
  BakedGrid baked = readBakedGrid(request.relit);
  const int threads = threadsOf(options);
  // cells that the bake of the grid found without air are not searched again
  const PreparedScene scene = readScene(request, options, {}, threads, knownAir(request.relit, baked));
  requireFunctionsOf(scene, table, options.representation, request.relit, baked);
  if (!baked.grid.groups.empty() && lightGroupNames(scene.source).empty())
    std::cerr << "light: the grid's " << baked.grid.groups.size()
              << " groups of light become one; to keep them, give --light-groups as in its bake\n";
  RelightReport report;
  report.light = relight(scene, options, table, &baked);
  const std::string bytes = fileBytes(baked.grid, options, baked.metadata);
  writeFileAtomically(request.out, bytes);
  warnOfDarkness(scene, options, report.light);
  report.scene = scene.source.id;
  report.grid = request.relit;
  report.probes = baked.grid.tree.probeCount();
  report.file_bytes = bytes.size();
  report.peak_memory_bytes = peakMemoryBytes();
  report.notes = scene.source.notes.size();
  report.wall_s = secondsSince(start);
  std::cerr << toSummary(report, request.out);
  writeJson(request.json, toJson(report));
}

void run(Request request, const BakeOptions& options, const OptionTable& table) {
  const auto start = std::chrono::steady_clock::now();
  if (request.weights.empty()) {
    request.weights = shippedWeights(options.representation, weightsFolders(options.draft));
  }
  // outputs and contradictions before any file is read: a bake takes minutes
  std::vector<std::string> inputs = filesOfLight(options.light_set, options.scene_light);
  inputs.insert(inputs.end(), request.weights.begin(), request.weights.end());
  inputs.insert(inputs.end(), {request.scene, request.config});
  checkOutputs(request, inputs);
  if (options.light == "none" && !options.light_set.empty()) throw UsageError("--light-set cannot be combined with --light none");
  if (options.light == "none" && (options.thin_error > 0.0 || options.max_bytes > 0.0))
    throw UsageError(std::string(options.thin_error > 0.0 ? "--thin-error" : "--max-bytes") +
                     " cannot be combined with --light none: thinning needs light");
  const GridPrecision stored{options.policy.theta_precision, options.light_error};
  const auto [generators, weight_files] = loadGenerators(request.weights);
  // the hashes of the weights belong to the grid's provenance
  std::vector<WeightsUsed> weights;
  for (size_t g = 0; g < generators.size(); ++g) {
    weights.push_back({representationName(generators[g].representation()), fileSha256(weight_files[g]),
                       std::filesystem::file_size(weight_files[g])});
  }

  std::map<std::string, std::string> weights_sha256;
  for (const WeightsUsed& used : weights) weights_sha256[kWeightsRole + used.representation] = used.sha256;

  const int threads = threadsOf(options);
  const PreparedScene scene = readScene(request, options, generators, threads);
  const double load_s = secondsSince(start);
  chooseOut(scene, inputs, &request);
  const GridMetadata metadata = bakeMetadata(scene, bakedOptions(table), weights_sha256);
  Bake bake = bakeScene(scene, generators, options, temporaryFolder(), metadata);
  const std::string bytes = fileBytes(bake.grid, options, metadata);
  writeFileAtomically(request.out, bytes);

  BakeReport report;
  report.scene = scene.source.id;
  report.notes = scene.source.notes.size();
  report.weights = weights;
  std::vector<uint64_t> weights_bytes;
  weights_bytes.reserve(weights.size());
  for (const WeightsUsed& used : weights) weights_bytes.push_back(used.bytes);
  report.threads = threads;
  // savings read the statistics, which the report then takes over
  report.savings = savingsOf(bake, generators, options.policy, stored, weights_bytes, report.threads);
  report.statistics = std::move(bake.statistics);
  report.statistics.load_wall_s = load_s;
  report.policy = options.policy;
  report.file_bytes = bytes.size();
  report.theta_bytes = lightGridBytes(bake.grid, {stored.theta, {}}).theta;  // light would be coded for nothing
  report.peak_memory_bytes = peakMemoryBytes();
  report.simd = chosenSimdTarget();
  warnOfNothing(scene, options, report.statistics);
  if (request.is_verbose) std::cerr << toTable(report);
  std::cerr << toSummary(report, request.out);
  writeJson(request.json, toJson(report));
}

// One of the three, and whatever comes of it the files that it asked for.
void bakeOrCheck(const Request& request, const BakeOptions& options, const OptionTable& table) {
  if (!request.inputs.empty()) {
    std::vector<std::string> others = request.weights;
    others.insert(others.end(), {request.scene, request.config, request.relit, request.checked, request.out, request.json});
    checkOutput(request.inputs, kInputsFiles, "--inputs", others);
  }
  const auto writeInputs = [&] {
    if (!request.inputs.empty()) writeFileAtomically(request.inputs, inputsText(inputsSoFar()));
  };
  try {
    if (!request.checked.empty()) {
      runCheck(request, options, table);
    } else if (!request.relit.empty()) {
      runRelight(request, options, table);
    } else {
      run(request, options, table);
    }
  } catch (const std::exception&) {
    writeInputs();
    throw;
  }
  writeInputs();
}

nlohmann::ordered_json describeFile(const std::string& path) {
  auto [grid, metadata] = readBakedGrid(path);
  nlohmann::ordered_json json = {{"scene", metadata["scene"]},
                                 {"probes", grid.tree.probeCount()},
                                 {"cells", grid.tree.cellCount()},
                                 {"spacing_m", bakedSpacing(grid, metadata)},
                                 {"functions", grid.functionCount()},
                                 {"has_light", !grid.light.empty()},
                                 {"light_axes", grid.packed_light.axes.size()},
                                 {"light_bytes", grid.light.empty() ? 0 : packedLightBytes(grid)}};
  for (const LightGroup& group : grid.groups) {
    json["light_groups"].push_back(group.name);
    if (group.begins_dark) json["light_groups_dark"].push_back(group.name);
  }
  for (const Representation& representation : grid.representations)
    json["representations"].push_back(representationName(representation));
  json["verified"] = kVerifiedByDigest;
  json["origin"] = parsedOrText(metadata["provenance"]);
  return json;
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "info") == 0)
    return nlg::fileInfoMain(argc - 1, argv + 1, {"nlg-bake info", "light grids (.safetensors)", "bake", nlg::describeFile});
  if (argc > 1 && std::strcmp(argv[1], "probes") == 0) return nlg::probeListMain(argc - 1, argv + 1);
  CLI::App app{
      "Bakes one scene into a light grid: places probes, computes their weighting functions, and lights them.\n"
      "nlg-bake SCENE: with the supplied weights.\n"
      "nlg-bake SCENE --weights W1 [W2 ...] --out GRID: with your own weights; the scene comes first, because --weights takes "
      "several files.\n"
      "nlg-bake SCENE --relight GRID: computes only the light of a baked grid again.\n"
      "nlg-bake SCENE --check GRID: whether a grid is up to date.\n"
      "nlg-bake info GRID ...: verifies and describes light grids.\n"
      "nlg-bake probes GRID: prints the probes of a grid as a table.",
      "nlg-bake"};
  nlg::Request request;
  nlg::BakeOptions options;
  options.spacing_m = 0.0;  // chosen by the scene
  nlg::OptionTable table("bake");
  nlg::describe(options, table);
  table.addNote(nlg::stagesHelp({}));
  table.common({"unit", "spacing_m", "extent_m", "sky", "sun", "light_unit", "intensity", "light_direct", "out"});
  app.add_option("scene", request.scene, nlg::sceneForms())->required();
  app.add_option("--weights", request.weights,
                 "weights of nlg-export. With several the bake chooses a representation for every function. None: the supplied "
                 "weights, in the folder $NLG_WEIGHTS or beside the installed program");
  const CLI::Option* out =
      app.add_option("--out", request.out, "light grid to write. None: SCENE.safetensors in the current folder");
  app.add_option("--relight", request.relit,
                 "light grid of this scene, baked with the same settings: its probes and functions are reused, and only light is "
                 "computed again");
  app.add_option("--check", request.checked,
                 "light grid to compare with what this command would bake; nothing is baked. Exit code 6 if it is out of date, "
                 "with what has changed");
  app.add_option("--json", request.json,
                 "file for the report of the bake or of --check, as one line of JSON. -: standard output");
  app.add_option("--inputs", request.inputs,
                 "file for the names of all files and folders that the bake reads or looks for, as a JSON list for build "
                 "systems, also after an error. Light grids and programs are not listed");
  app.add_flag("--verbose", request.is_verbose, "also print tables of stages, errors and savings");
  return nlg::runTool(argc, argv, app, table, [&] {
    const CLI::Option* config = app.get_option("--config");
    request.out_is_given = out->count() > 0;
    if (config->count() > 0) request.config = config->as<std::string>();
    nlg::takeThetaPrecision(&options);
    nlg::chooseSimd(options.simd);
    nlg::bakeOrCheck(request, options, table);
  });
}
