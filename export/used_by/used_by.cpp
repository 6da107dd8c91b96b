#include "export/used_by/used_by.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>

#include <nlohmann/json.hpp>

#include "nlg/generator.h"
#include "nlg/light_grid.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/output_path.h"

namespace nlg {
namespace {

constexpr std::string_view kInput = "weights of ";  // of the provenance of a light grid: role → SHA-256

BakedWeights ofLightGrid(const std::string& path) {
  LightGrid grid;
  GridMetadata metadata;
  requireRead(path, readLightGridFile(path, &grid, &metadata), "the light grid of nlg-bake");
  BakedWeights baked;
  baked.scene = metadata["scene"];
  try {
    const nlohmann::json provenance = nlohmann::json::parse(metadata["provenance"]);
    for (const auto& [role, sha256] : provenance.at("inputs").items()) {
      if (role.starts_with(kInput)) baked.sha256[role.substr(kInput.size())] = sha256.get<std::string>();
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, "provenance", "the inputs of a bake", error.what());
  }
  for (const Representation& representation : grid.representations) baked.used.emplace_back(representationName(representation));
  return baked;
}

BakedWeights ofReport(const std::string& path) {
  BakedWeights baked;
  try {
    const nlohmann::json report = nlohmann::json::parse(readFile(path));
    baked.scene = report.at("scene").get<std::string>();
    for (const auto& [name, weights] : report.at("weights").items()) {
      baked.sha256[name] = weights.at("sha256").get<std::string>();
    }
    for (const auto& [name, functions] : report.at("representations").items()) {
      if (functions.get<uint64_t>() > 0) baked.used.push_back(name);
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, "report", "the line of JSON that nlg-bake writes with --json", error.what());
  }
  return baked;
}

namespace fs = std::filesystem;

std::string copyPath(const std::string& folder, const std::string& representation) {
  return (fs::path(folder) / (representation + ".safetensors")).string();
}

// What a file is, by itself.
BakeWeights lookAt(const std::string& path) {
  WeightsFile file;
  GeneratorData data;
  requireRead(path, readWeightsFile(path, &file), "the weights of a generator");
  requireRead(path, generatorFromWeights(file, &data), "the weights of a generator");
  return {path, representationName(data.representation), fileSha256(path), fs::file_size(path)};
}

void run(const std::string& bake_path, const std::vector<std::string>& paths, const std::string& folder) {
  const BakedWeights baked = readBakedWeights(bake_path);
  const std::vector<BakeWeights> weights = weightsUsedBy(baked, bake_path, paths);
  copyUsedWeights(weights, bake_path, folder);
  nlohmann::ordered_json written = nlohmann::ordered_json::array(), left_out = nlohmann::ordered_json::array();
  uint64_t bytes_written = 0, bytes_left_out = 0;
  for (const BakeWeights& file : weights) {
    if (file.used) {
      bytes_written += file.bytes;
      written.push_back({{"representation", file.representation}, {"bytes", file.bytes}});
    } else {
      bytes_left_out += file.bytes;
      left_out.push_back({{"representation", file.representation}, {"bytes", file.bytes}, {"why", file.why}});
      std::cerr << "left out: " << file.path << ", " << file.bytes << " bytes: " << file.why << '\n';
    }
  }
  const nlohmann::ordered_json line = {{"scene", baked.scene},
                                       {"written", written},
                                       {"bytes_written", bytes_written},
                                       {"left_out", left_out},
                                       {"bytes_left_out", bytes_left_out}};
  std::cout << line.dump() << '\n';
}

}  // namespace

BakedWeights readBakedWeights(const std::string& path) {
  const BakedWeights baked = path.ends_with(".json") ? ofReport(path) : ofLightGrid(path);
  for (const std::string& name : baked.used) {
    if (!baked.sha256.contains(name)) throw InputError(path, "weights of " + name, "their SHA-256", "none");
  }
  return baked;
}

std::vector<BakeWeights> weightsUsedBy(const BakedWeights& baked, const std::string& bake_path,
                                       const std::vector<std::string>& paths) {
  std::vector<BakeWeights> weights;
  OneFileEach given("--weights", "representation");
  for (const std::string& path : paths) {
    BakeWeights file = lookAt(path);
    given.add(path, file.representation);
    // only the very weights of the bake will do: others of the same representation are an error
    const auto baked_with = baked.sha256.find(file.representation);
    if (baked_with == baked.sha256.end()) {
      file.why = "the bake was not given any of " + file.representation;
    } else if (baked_with->second != file.sha256) {
      throw InputError(path, "SHA-256", "the weights that " + bake_path + " was baked with, " + baked_with->second, file.sha256);
    } else if (std::find(baked.used.begin(), baked.used.end(), file.representation) == baked.used.end()) {
      file.why = "no function of the scene has " + file.representation;
    } else {
      file.used = true;
    }
    weights.push_back(file);
  }
  // every representation that some function has needs its weights
  for (const std::string& name : baked.used) {
    const bool found =
        std::any_of(weights.begin(), weights.end(), [&](const BakeWeights& file) { return file.representation == name; });
    if (!found) throw InputError(bake_path, "functions of " + name, "its weights among the files of --weights", "none");
  }
  return weights;
}

void copyUsedWeights(const std::vector<BakeWeights>& weights, const std::string& bake_path, const std::string& folder) {
  requireOutputFolder(folder);
  std::vector<std::string> inputs = {bake_path};
  for (const BakeWeights& file : weights) inputs.push_back(file.path);
  // all refusals before the first copy
  for (const BakeWeights& file : weights) {
    const std::string path = copyPath(folder, file.representation);
    refuseToReplaceInputs(path, inputs);
    std::error_code error;
    if (!file.used && fs::exists(path, error)) {
      throw UsageError("--out", "a folder without weights that the scene does not use", path);
    }
  }
  for (const BakeWeights& file : weights) {
    if (!file.used) continue;
    const std::string bytes = readFile(file.path);
    if (sha256(bytes) != file.sha256) throw InputError(file.path, "SHA-256", "the file that was read before", "another one");
    writeFileAtomically(copyPath(folder, file.representation), bytes);
  }
}

int usedByMain(int argc, char** argv) {
  CLI::App app{"Copies the weights that a bake used, and prints what is left out.", "nlg-export used-by"};
  std::string bake, out;
  std::vector<std::string> weights;
  OptionTable table("export");
  app.add_option("--bake", bake, "light grid (.safetensors), or the report of nlg-bake --json (.json)")->required();
  app.add_option("--weights", weights, "weights of nlg-export (.safetensors)")->required();
  app.add_option("--out", out, "folder for REPRESENTATION.safetensors")->required();
  return runTool(argc, argv, app, table, [&] { run(bake, weights, out); });
}

}  // namespace nlg
