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
  writeOnnx(file, data, fileSha256(weights), out);
  const nlohmann::ordered_json line = {{"representation", representationName(data.representation)},
                                       {"bytes", std::filesystem::file_size(out)}};
  std::cout << line.dump() << '\n';
}

}  // namespace

void requireOnnxName(const std::string& out) {
  if (!out.ends_with(kEnding)) throw UsageError("ONNX", "a name that ends in .onnx", "'" + out + "'");
}

void writeOnnx(const WeightsFile& file, const GeneratorData& data, const std::string& sha256, const std::string& out) {
  std::map<std::string, std::string> metadata = file.metadata;
  metadata["weights_sha256"] = sha256;
  writeFileAtomically(out, onnxFromGenerator(data, metadata));
}

int onnxMain(int argc, char** argv) {
  CLI::App app{"Converts the weights of a generator to ONNX.", "nlg-export onnx"};
  std::string weights, out;
  OptionTable table("export");
  app.add_option("--weights", weights, "weights of nlg-export (.safetensors)")->required();
  app.add_option("--out", out, "model to write (.onnx)")->required();
  return runTool(argc, argv, app, table, [&] { run(weights, out); });
}

}  // namespace nlg
