#include "export/onnx_export.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include <nlohmann/json.hpp>

#include "export/onnx_file/onnx_file.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/require_read.h"
#include "tool/tool_main.h"

namespace nlg {
namespace {

constexpr std::string_view kEnding = ".onnx";

void run(const std::string& weights, const std::string& out) {
  requireOnnxName(out);
  refuseToReplaceInputs(out, {weights});
  WeightsFile file;
  GeneratorData data;
  requireRead(weights, readWeightsFile(weights, &file), "the weights of a generator");
  requireRead(weights, generatorFromWeights(file, &data), "the weights of a generator");
  nlohmann::ordered_json written = nlohmann::ordered_json::array();
  for (const std::string& path : writeOnnx(file, data, fileSha256(weights), out)) {
    written.push_back({{"file", std::filesystem::path(path).filename()}, {"bytes", std::filesystem::file_size(path)}});
  }
  const nlohmann::ordered_json line = {{"representation", representationName(data.representation)}, {"written", written}};
  std::cout << line.dump() << '\n';
}

}  // namespace

void requireOnnxName(const std::string& out) {
  if (!out.ends_with(kEnding)) throw UsageError("ONNX", "a name that ends in .onnx", "'" + out + "'");
}

std::vector<std::string> writeOnnx(const WeightsFile& file, const GeneratorData& data, const std::string& sha256,
                                   const std::string& out) {
  std::map<std::string, std::string> metadata = file.metadata;
  metadata["weights_sha256"] = sha256;
  std::vector<std::string> written = {out};
  writeFileAtomically(out, onnxFromGenerator(data, metadata));
  if (data.correction.step_count > 0) {
    written.push_back(out.substr(0, out.size() - kEnding.size()) + ".correction.onnx");
    const LayerChain chain{"features", "theta_change", data.correction.layers, data.slope, data.output_scale};
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
