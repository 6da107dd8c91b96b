#include "export/onnx_export.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include <nlohmann/json.hpp>

#include "export/onnx_file/onnx_file.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"

namespace nlg {
namespace {

constexpr std::string_view kEnding = ".onnx";

// The layers `correction.layer.0`, `correction.layer.1`, …; none when the file has no correction step.
std::vector<GeneratorLayer> correctionLayers(const std::string& weights, const WeightsFile& file, size_t theta_count) {
  std::vector<GeneratorLayer> layers;
  for (;;) {
    const std::string name = "correction.layer." + std::to_string(layers.size());
    const auto weight = file.tensors.find(name + ".weight"), bias = file.tensors.find(name + ".bias");
    if (weight == file.tensors.end()) break;
    const std::vector<uint64_t>& shape = weight->second.shape;
    const bool fits = shape.size() == 2 && bias != file.tensors.end() && bias->second.shape == std::vector{shape[0]};
    if (!fits || (!layers.empty() && shape[1] != static_cast<uint64_t>(layers.back().output_count))) {
      throw InputError(weights, name, "outputs x inputs, as many inputs as the layer before has outputs, and a bias",
                       "another shape");
    }
    layers.push_back({static_cast<int>(shape[1]), static_cast<int>(shape[0]), weight->second.values, bias->second.values});
  }
  if (!layers.empty() && static_cast<size_t>(layers.back().output_count) != theta_count) {
    throw InputError(weights, "correction", std::to_string(theta_count) + " outputs of the last layer",
                     std::to_string(layers.back().output_count));
  }
  return layers;
}

void run(const std::string& weights, const std::string& out) {
  requireOnnxName(out);
  refuseToReplaceInputs(out, {weights});
  WeightsFile file;
  GeneratorData data;
  WeightsResult result = readWeightsFile(weights, &file);
  if (result.ok()) result = generatorFromWeights(file, &data);
  if (!result.ok()) throw InputError(weights, weightsStatusName(result.status), "the weights of a generator", result.detail);
  nlohmann::ordered_json written = nlohmann::ordered_json::array();
  for (const std::string& path : writeOnnx(weights, file, data, fileSha256(weights), out)) {
    written.push_back({{"file", std::filesystem::path(path).filename()}, {"bytes", std::filesystem::file_size(path)}});
  }
  const nlohmann::ordered_json line = {{"representation", representationName(data.representation)}, {"written", written}};
  std::cout << line.dump() << '\n';
}

}  // namespace

void requireOnnxName(const std::string& out) {
  if (!out.ends_with(kEnding)) throw UsageError("ONNX", "a name that ends in .onnx", "'" + out + "'");
}

std::vector<std::string> writeOnnx(const std::string& weights, const WeightsFile& file, const GeneratorData& data,
                                   const std::string& sha256, const std::string& out) {
  std::map<std::string, std::string> metadata = file.metadata;
  metadata["weights_sha256"] = sha256;
  std::vector<std::string> written = {out};
  const std::vector<GeneratorLayer> correction = correctionLayers(weights, file, data.theta0.size());
  writeFileAtomically(out, onnxFromGenerator(data, metadata));
  if (!correction.empty()) {
    written.push_back(out.substr(0, out.size() - kEnding.size()) + ".correction.onnx");
    const LayerChain chain{"features", "theta_change", correction, data.slope, data.output_scale};
    writeFileAtomically(written.back(), onnxFromLayers(chain, metadata));
  }
  return written;
}

int onnxMain(int argc, char** argv) {
  CLI::App app{"Converts the weights of a generator to ONNX; its learned correction step, if it has one, to a second file.",
               "nlg-export onnx"};
  std::string weights, out;
  OptionTable table("export");
  app.add_option("--weights", weights, "weights of nlg-export (.safetensors)")->required();
  app.add_option("--out", out, "the model to write (.onnx)")->required();
  return runTool(argc, argv, app, table, [&] { run(weights, out); });
}

}  // namespace nlg
