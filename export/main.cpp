// nlg-export: a finished checkpoint → the weights file of the bake-time evaluator, checked against libtorch on real functions.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "export/weights_file/weights_file.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "tool/atomic_file.h"
#include "tool/provenance.h"
#include "tool/tool_main.h"
#include "train/generator/trainer.h"

namespace nlg {
namespace {

struct ExportOptions {
  int parity_functions = 1024;
  double parity_tolerance = 1e-4;
};

struct Request {
  std::string checkpoint, basis, out;
  std::vector<std::string> shards;
};

// The network's shape as the run stored it in its options.
TrainOptions storedOptions(const std::string& path, const std::string& options_json, int coefficient_count) {
  TrainOptions options;
  try {
    const nlohmann::json json = nlohmann::json::parse(options_json);
    options.representation_slope = json.at("representation_slope").get<double>();
    options.shape = {coefficient_count, json.at("width").get<int>(), json.at("layers").get<int>(),
                     json.at("generator_slope").get<double>(), json.at("output_scale").get<double>()};
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path, "options", "the options of a training run", error.what());
  }
  return options;
}

struct Parity {
  double theta = 0.0;   // largest |theta of libtorch - theta of the evaluator|
  double output = 0.0;  // largest difference of the representations that they stand for, at the support points
  double held_out_rmse = 0.0;
  int64_t functions = 0;
};

// The larger of the two, and NaN once there was one: std::max would lose it.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = value;
}

// Real functions through both: libtorch's network on the coefficients, the evaluator on the bytes.
Parity compare(const TrainingState& state, const Generator& generator, const TrainingData& data, int limit) {
  torch::NoGradGuard guard;
  Parity parity;
  parity.functions = std::min<int64_t>(limit, data.functionCount());
  GeneratorScratch scratch(generator);
  GeneratorNetwork network = state.average;
  const PointSet& points = stratifiedSupportPoints();
  AlignedFloats evaluator_values(points.padded_count), torch_values(points.padded_count);
  for (int64_t i = 0; i < parity.functions; ++i) {
    const int64_t index = i * data.functionCount() / parity.functions;
    const torch::Tensor torch_theta = network->forward(coefficientBatch(data, {{index}})).contiguous();
    Theta theta(generator.representation().thetaCount());
    generator.generate(data.function(index).phi, 1, theta.data(), &scratch);
    for (size_t k = 0; k < theta.size(); ++k) {
      raise(parity.theta, std::fabs(double{theta[k]} - torch_theta.data_ptr<float>()[k]));
    }
    evaluate(generator.representation(), points, theta.data(), evaluator_values.data());
    evaluate(generator.representation(), points, torch_theta.data_ptr<float>(), torch_values.data());
    for (int p = 0; p < points.count; ++p) {
      raise(parity.output, std::fabs(double{evaluator_values[p]} - torch_values[p]));
    }
    parity.held_out_rmse += functionRmse(
        generator.representation(), decodeFunction(data.function(index), pointOrder(generator.representation())), theta.data());
  }
  if (parity.functions > 0) parity.held_out_rmse /= static_cast<double>(parity.functions);
  return parity;
}

void run(const Request& request, const ExportOptions& options, const OptionTable& table) {
  const BasisFile basis = readBasisFile(request.basis);
  const RunIdentity identity = readIdentity(request.checkpoint);
  const std::string basis_sha256 = fileSha256(request.basis);
  if (identity.basis_sha256 != basis_sha256) {
    throw InputError(request.basis, "SHA-256", "the basis that the checkpoint was trained on, " + identity.basis_sha256,
                     basis_sha256);
  }
  Representation representation;
  if (!findRepresentation(identity.representation, &representation)) {
    throw InputError(request.checkpoint, "representation", representationNames(), "'" + identity.representation + "'");
  }
  const TrainOptions train_options =
      storedOptions(request.checkpoint, identity.options_json, basis.basis.data.coefficientCount());
  representation.slope = static_cast<float>(train_options.representation_slope);
  TrainingState state = makeState(train_options, Theta(representation.thetaCount()));
  readCheckpoint(request.checkpoint, identity, &state);

  // the file is checked as a baker would read it: from its bytes
  WeightsFile file = weightsFromGenerator(state.average->toData(representation, basis.basis.data));
  GeneratorData data;
  WeightsFile parsed;
  const WeightsResult parse_result = parseWeights(serializeWeights(file), &parsed);
  if (!parse_result.ok()) throw CheckFailed("exported weights", "a readable file", parse_result.detail);
  const WeightsResult load_result = generatorFromWeights(parsed, &data);
  if (!load_result.ok()) throw CheckFailed("exported weights", "a loadable generator", load_result.detail);
  const TrainingData functions(readFunctionSet(request.shards, supportPattern().hash, kSupportPointCount), basis.basis.data);
  if (functions.functionCount() == 0) throw InputError(request.shards.front(), "functions", "at least one in all shards", "none");
  const Parity parity = compare(state, Generator(data), functions, options.parity_functions);
  double difference = parity.theta;
  raise(difference, parity.output);
  if (!(difference < options.parity_tolerance) || !std::isfinite(parity.held_out_rmse)) {
    throw CheckFailed("parity of libtorch and evaluator over " + std::to_string(parity.functions) + " functions",
                      "a difference below " + std::to_string(options.parity_tolerance), std::to_string(difference));
  }

  const nlohmann::ordered_json origin =
      provenance("nlg-export", table.toJson(), {{"checkpoint", fileSha256(request.checkpoint)}, {"basis", basis_sha256}});
  file.metadata["training_set_sha256"] = identity.training_set_sha256;
  file.metadata["training_functions"] = std::to_string(basis.basis.function_count);
  file.metadata["held_out_rmse_mean"] = std::to_string(parity.held_out_rmse);
  file.metadata["parity_theta"] = std::to_string(parity.theta);
  file.metadata["provenance"] = origin.dump();
  writeFileAtomically(request.out, serializeWeights(file));
  const nlohmann::ordered_json result = {{"representation", identity.representation},
                                         {"parity_functions", parity.functions},
                                         {"parity_theta", parity.theta},
                                         {"parity_output", parity.output},
                                         {"held_out_rmse", parity.held_out_rmse}};
  std::cout << result.dump() << '\n';
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  CLI::App app{"Exports a trained generator for the bake-time evaluator and checks the two against each other.", "nlg-export"};
  nlg::Request request;
  nlg::ExportOptions options;
  nlg::OptionTable table("export");
  table.add("parity_functions", &options.parity_functions, "real functions on which libtorch and the evaluator are compared", 1,
            1000000);
  table.add("parity_tolerance", &options.parity_tolerance, "largest difference allowed, of theta and of what it stands for", 0.0,
            1.0);
  app.add_option("--checkpoint", request.checkpoint, "the finished checkpoint of nlg-train")->required();
  app.add_option("--basis", request.basis, "the basis that it was trained on")->required();
  app.add_option("--shards", request.shards, "real functions to compare on (held-out shards)")->required();
  app.add_option("--out", request.out, "the weights to write (.safetensors)")->required();
  return nlg::runTool(argc, argv, app, table, [&] { nlg::run(request, options, table); });
}
