// nlg-export: a finished checkpoint → the weights file of the bake-time evaluator, checked against libtorch on real functions;
// weights → ONNX; and the commands that need no libtorch.

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "export/commands.h"
#include "export/onnx_file/onnx_file.h"
#include "export/shader/shader_export.h"
#include "nlg/generator.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tool/atomic_file.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/provenance.h"
#include "train/generator/run/trainer.h"
#include "train/torch_threads.h"

namespace nlg {
namespace {

constexpr std::string_view kEnding = ".onnx";

// throws   UsageError when the name of a model to write does not end in .onnx
void requireOnnxName(const std::string& out) {
  if (!out.ends_with(kEnding)) throw UsageError("ONNX", "a name that ends in .onnx", "'" + out + "'");
}

// Writes the generator of a weights file as ONNX. Texts of the file travel along, and its SHA-256 as `weights_sha256`.
//
// data      the generator of `file`
// out       a name that requireOnnxName takes
// throws    OutputError
void writeOnnx(const WeightsFile& file, const GeneratorData& data, const std::string& sha256, const std::string& out) {
  std::map<std::string, std::string> metadata = file.metadata;
  metadata["weights_sha256"] = sha256;
  writeFileAtomically(out, onnxFromGenerator(data, metadata));
}

void convertToOnnx(const std::string& weights, const std::string& out) {
  requireOnnxName(out);
  refuseToReplace(out, {weights}, kExportedFiles);
  WeightsFile file;
  GeneratorData data;
  requireRead(weights, readWeightsFile(weights, &file), "the weights of a generator");
  requireRead(weights, generatorFromWeights(file, &data), "the weights of a generator");
  writeOnnx(file, data, fileSha256(weights), out);
  const nlohmann::ordered_json line = {{"representation", representationName(data.representation)},
                                       {"bytes", std::filesystem::file_size(out)}};
  std::cout << line.dump() << '\n';
}

// The tool's command `onnx`: nlg-export onnx --weights FILE --out FILE.
int onnxMain(int argc, char** argv) {
  CLI::App app{"Converts the weights of a generator to ONNX.", "nlg-export onnx"};
  std::string weights, out;
  OptionTable table("export");
  app.add_option("--weights", weights, "weights of nlg-export (.safetensors)")->required();
  app.add_option("--out", out, "model to write (.onnx)")->required();
  return runTool(argc, argv, app, table, [&] { convertToOnnx(weights, out); });
}

struct ExportOptions {
  std::string dtype = "float16";
  int parity_functions = 1024;
  double parity_tolerance = 1e-4;
};

struct Request {
  std::string checkpoint, basis, out, onnx;
  std::vector<std::string> shards;
};

// The network's shape as the run stored it in its options.
TrainOptions storedOptions(const std::string& path, const std::string& options_json) {
  TrainOptions options;
  try {
    const nlohmann::json json = nlohmann::json::parse(options_json);
    options.representation_slope = json.at("representation_slope").get<double>();
    // checkpoints of 1.0 do not say what they read
    options.input = json.value("input", "coefficients");
    options.coefficients = json.at("coefficients").get<int>();
    options.whitening = json.at("whitening").get<double>();
    options.shape.width = json.at("width").get<int>();
    options.shape.layer_count = json.at("layers").get<int>();
    options.shape.slope = json.at("generator_slope").get<double>();
    options.shape.output_scale = json.at("output_scale").get<double>();
    options.shape.exact_last_layer = json.at("exact_last_layer").get<bool>();
    // checkpoints from before there were codes have none
    options.shape.dictionary_resolution = json.value("dictionary_resolution", options.shape.dictionary_resolution);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, "options", "the options of a training run", error.what());
  }
  return options;
}

struct Parity {
  double theta = 0.0;   // largest |theta of libtorch - theta of the evaluator| over |theta|, where that is above 1
  double output = 0.0;  // largest difference of the representations that they stand for, at the support points
  int64_t functions = 0;
};

// The larger of the two, and NaN once there was one: std::max would lose it.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = value;
}

// The generator as a baker gets it: from the file's bytes.
GeneratorData asLoaded(const WeightsFile& file) {
  WeightsFile parsed;
  GeneratorData data;
  FileResult result = parseWeights(serializeWeights(file), &parsed);
  if (result.ok()) result = generatorFromWeights(parsed, &data);
  if (!result.ok()) throw CheckFailed("exported weights", "a loadable generator", result.detail);
  return data;
}

// All that is large: the components and the layers' matrices. The mean stays as it is: its error would be every function's.
void roundMatrices(WeightsFile* file) {
  for (auto& [name, tensor] : file->tensors) {
    if (name != "basis.components" && !name.ends_with(".weight")) continue;
    const FileResult result = roundToFloat16(name, &tensor);
    if (!result.ok()) throw CheckFailed("weights as float16", "values of at most 65504", result.detail);
  }
}

// The same of libtorch's network, so that both sides of the parity check have the numbers of the file.
void roundMatrices(GeneratorNetwork& network) {
  const torch::NoGradGuard guard;
  for (torch::Tensor& parameter : network->parameters()) {
    if (parameter.dim() >= 2) parameter.copy_(parameter.to(torch::kHalf));
  }
}

// Functions at equal distances; the i-th of count.
int64_t spread(const TrainingData& data, int64_t i, int64_t count) { return i * data.functionCount() / count; }

// Mean blend RMSE of predicted theta.
double meanBlendRmse(const Generator& generator, const TrainingData& data, int limit) {
  const int64_t count = std::min<int64_t>(limit, data.functionCount());
  GeneratorScratch scratch(generator);
  Theta theta(generator.representation().thetaCount());
  double sum = 0.0;
  for (int64_t i = 0; i < count; ++i) {
    const StoredFunction function = data.function(spread(data, i, count));
    generator.generate(&function, 1, theta.data(), &scratch);
    sum += functionRmse(generator.representation(),
                        decodeFunction(function, pointOrder(generator.representation()), CheckOptions().loss()), theta.data());
  }
  return sum / static_cast<double>(count);
}

// Real functions through both: libtorch's network on what it was trained on, the evaluator on the bytes.
Parity compare(const TrainingState& state, const Generator& generator, const TrainingData& data, int limit) {
  torch::NoGradGuard guard;
  Parity parity;
  parity.functions = std::min<int64_t>(limit, data.functionCount());
  GeneratorScratch scratch(generator);
  GeneratorNetwork network = state.average;
  const PointSet& points = stratifiedSupportPoints();
  AlignedFloats evaluator_values(points.padded_count), torch_values(points.padded_count);
  for (int64_t i = 0; i < parity.functions; ++i) {
    const int64_t index = spread(data, i, parity.functions);
    const torch::Tensor torch_theta = network->forward(inputBatch(data, {{index}})).contiguous();
    Theta theta(generator.representation().thetaCount());
    const StoredFunction function = data.function(index);
    generator.generate(&function, 1, theta.data(), &scratch);
    for (size_t k = 0; k < theta.size(); ++k) {
      const double torch_value = torch_theta.data_ptr<float>()[k];
      raise(parity.theta, std::fabs(theta[k] - torch_value) / std::max(1.0, std::fabs(torch_value)));
    }
    // where codes differ in their last bit, a rounded logit may differ by a step
    if (generator.representation().isCode()) continue;
    evaluate(generator.representation(), points, theta.data(), evaluator_values.data());
    evaluate(generator.representation(), points, torch_theta.data_ptr<float>(), torch_values.data());
    for (int p = 0; p < points.count; ++p) {
      raise(parity.output, std::fabs(double{evaluator_values[p]} - torch_values[p]));
    }
  }
  return parity;
}

// The checkpoint's averaged network, once it is sure that it belongs to the basis.
TrainingState readState(const Request& request, const CheckpointFile& checkpoint, const BasisFile& basis,
                        const std::string& basis_sha256, Representation* representation, BasisData* used) {
  const RunIdentity& identity = checkpoint.identity();
  if (identity.basis_sha256 != basis_sha256) {
    throw InputError(request.basis, "SHA-256", "the basis that the checkpoint was trained on, " + identity.basis_sha256,
                     basis_sha256);
  }
  if (!findRepresentation(identity.representation, representation)) {
    throw InputError(request.checkpoint, "representation", representationNames(), "'" + identity.representation + "'");
  }
  TrainOptions options = storedOptions(request.checkpoint, identity.options_json);
  *used = usedBasis(options, basis.basis);
  options.shape.input = used->input;
  options.shape.coefficient_count = used->coefficientCount();
  options.shape.code_count = representation->code_count;
  representation->slope = static_cast<float>(options.representation_slope);
  TrainingState state = makeState(options, Theta(representation->thetaCount()));
  readCheckpoint(checkpoint, identity, &state);
  return state;
}

// What nobody asks for, and is sometimes meant: parity says as much of functions that were trained on, an error of them says little.
void tellWhatIsUnusual(const Request& request, const std::string& options_json, int64_t step, const Scenes& scenes) {
  // read before, by storedOptions
  const nlohmann::json options = nlohmann::json::parse(options_json);
  if (const int64_t steps = options.value("steps", step); step < steps)
    std::cerr << "nlg-export: " << request.checkpoint << " is unfinished: step " << step << " of " << steps << '\n';
  // checkpoints of 1.0 do not name their scenes
  const auto [scene, other] = seenScene(options.value("training_scenes", Scenes()), scenes);
  if (!scene.empty())
    std::cerr << "nlg-export: " << scene << " of --shards was trained on, as " << other
              << ": held_out_blend_rmse is no error of unseen scenes\n";
}

// Of functions, over that of theta: a network that is hardly trained amplifies the last bits of theta, and a thousandth is still less
// than what rounding phi to a byte loses.
constexpr double kOutputTolerance = 10.0;

void checkParity(const Parity& parity, double held_out_blend_rmse, const ExportOptions& options) {
  const double most_output = kOutputTolerance * options.parity_tolerance;
  if (parity.theta < options.parity_tolerance && parity.output < most_output && std::isfinite(held_out_blend_rmse)) return;
  throw CheckFailed("parity of libtorch and evaluator over " + std::to_string(parity.functions) + " functions",
                    "differences below " + std::to_string(options.parity_tolerance) + " of theta and " +
                        std::to_string(most_output) + " of functions",
                    std::to_string(parity.theta) + " and " + std::to_string(parity.output));
}

void run(const Request& request, const ExportOptions& options, const OptionTable& table) {
  std::vector<std::string> inputs = request.shards;
  inputs.insert(inputs.end(), {request.checkpoint, request.basis});
  refuseToReplace(request.out, inputs, kExportedFiles);
  if (!request.onnx.empty()) {
    requireOnnxName(request.onnx);
    refuseToReplace(request.onnx, inputs, kExportedFiles, "--onnx");
  }
  computeOnCallingThreads();
  const BasisFile basis = readBasisFile(request.basis);
  const CheckpointFile checkpoint(request.checkpoint);
  const std::string basis_sha256 = fileSha256(request.basis);
  Representation representation;
  BasisData used;
  TrainingState state = readState(request, checkpoint, basis, basis_sha256, &representation, &used);

  WeightsFile file = weightsFromGenerator(state.average->toData(representation, used));
  // float32 as well, to say what rounding costs
  const Generator unrounded(asLoaded(file));
  if (options.dtype == "float16") {
    roundMatrices(&file);
    roundMatrices(state.average);
  }
  // read back from the file's bytes, as a baker gets it
  const GeneratorData data = asLoaded(file);
  const Generator generator(data);
  // coefficients of the basis that is exported
  const TrainingData functions(readFunctionSet(request.shards, supportPattern().hash, kSupportPointCount), data.basis,
                               data.basis);
  if (functions.functionCount() == 0) throw InputError(request.shards.front(), "functions", "at least one in all shards", "none");
  tellWhatIsUnusual(request, checkpoint.identity().options_json, state.step, functions.scenes());
  // a generator that the evaluator runs otherwise than libtorch is never written
  const Parity parity = compare(state, generator, functions, options.parity_functions);
  const double held_out_blend_rmse = meanBlendRmse(generator, functions, options.parity_functions);
  checkParity(parity, held_out_blend_rmse, options);

  // what made the weights travels in them
  const nlohmann::ordered_json origin =
      provenance("nlg-export", table.toJson(), {{"checkpoint", checkpoint.sha256()}, {"basis", basis_sha256}});
  file.metadata["training_options"] = checkpoint.identity().options_json;
  file.metadata["training_set_sha256"] = checkpoint.identity().training_set_sha256;
  file.metadata["basis_functions"] = std::to_string(basis.basis.function_count);
  file.metadata["held_out_blend_rmse_mean"] = std::to_string(held_out_blend_rmse);
  file.metadata["parity_theta"] = std::to_string(parity.theta);
  file.metadata["provenance"] = origin.dump();
  const std::string bytes = serializeWeights(file);
  writeFileAtomically(request.out, bytes);
  if (!request.onnx.empty()) writeOnnx(file, data, sha256(bytes), request.onnx);
  const nlohmann::ordered_json result = {
      {"representation", checkpoint.identity().representation},
      {"dtype", options.dtype},
      {"parity_functions", parity.functions},
      {"parity_theta", parity.theta},
      {"parity_output", parity.output},
      {"held_out_blend_rmse", held_out_blend_rmse},
      {"held_out_blend_rmse_float32", meanBlendRmse(unrounded, functions, options.parity_functions)}};
  std::cout << result.dump() << '\n';
}

}  // namespace

}  // namespace nlg

int main(int argc, char** argv) {
  if (const std::optional<int> status = nlg::runCommand(argc, argv)) return *status;
  if (argc > 1 && std::strcmp(argv[1], "onnx") == 0) return nlg::onnxMain(argc - 1, argv + 1);
  CLI::App app{
      "Exports a trained generator for the bake-time evaluator, and compares the two.\n"
      "" + std::string(nlg::kCommands) +
          "\n"
          "nlg-export onnx --weights FILE --out FILE: converts weights to ONNX.",
      "nlg-export"};
  nlg::Request request;
  nlg::ExportOptions options;
  nlg::OptionTable table("export");
  table.add("dtype", &options.dtype, "number format of matrices: float16 or float32. All else is float32",
            {"float16", "float32"});
  table.add("parity_functions", &options.parity_functions, "number of functions on which libtorch and the evaluator are compared",
            1, 1000000);
  table.add("parity_tolerance", &options.parity_tolerance,
            "maximum difference between libtorch and the evaluator, of theta; of functions ten times as much", 0.0, 1.0);
  app.add_option("--checkpoint", request.checkpoint, "finished checkpoint of nlg-train")->required();
  app.add_option("--basis", request.basis, "basis that the checkpoint was trained on")->required();
  app.add_option("--shards", request.shards, "held-out shards, on whose functions the two are compared")->required();
  app.add_option("--out", request.out, "weights to write (.safetensors)")->required();
  app.add_option("--onnx", request.onnx, "ONNX file of the generator to write as well (.onnx)");
  return nlg::runTool(argc, argv, app, table, [&] { nlg::run(request, options, table); });
}
