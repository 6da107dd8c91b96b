// nlg-pca: the PCA basis of a training set, and how much of held-out functions it keeps.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstring>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tool/atomic_file.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "train/basis/basis_file.h"
#include "train/blas_threads.h"

namespace nlg {
namespace {

struct PcaOptions {
  int components = 512;
};

struct Request {
  std::vector<std::string> shards, held_out;
  std::string out, from;
};

// Mean over the functions, then over their mirror images, and the share of functions in which each point is valid.
class MeanFunction {
 public:
  void add(const FunctionRows& shard) {
    for (uint64_t n = 0; n < shard.functionCount(); ++n) {
      for (int p = 0; p < kSupportPointCount; ++p) {
        phi_[p] += shard.phi[n * kSupportPointCount + p];
        valid_[p] += shard.validity[n * kValidityByteCount + p / 8] >> (p % 8) & 1;
      }
    }
    count_ += shard.functionCount();
  }

  void finish(BasisFile* file) const {
    for (int p = 0; p < kSupportPointCount; ++p) {
      double phi = 0.0, valid = 0.0;
      for (int mirror = 0; mirror < kMirrorCount; ++mirror) {
        phi += phi_[p ^ (mirror * kOctantPointCount)];
        valid += valid_[p ^ (mirror * kOctantPointCount)];
      }
      // over the functions in which the point is valid: elsewhere phi is 0 and free
      file->mean_function.push_back(static_cast<float>(valid > 0 ? phi / (255.0 * valid) : 0.0));
      file->mean_validity.push_back(static_cast<float>(valid / (kMirrorCount * std::max<double>(1.0, double(count_)))));
    }
  }

 private:
  std::vector<double> phi_ = std::vector<double>(kSupportPointCount, 0.0), valid_ = phi_;
  uint64_t count_ = 0;
};

// The basis of a generator that goes on being trained; the spectrum stays that of the functions. False where it reads samples: its
// components are its own, and the functions' basis serves.
bool takeBasis(const std::string& path, Basis* basis) {
  WeightsFile file;
  GeneratorData data;
  requireRead(path, readWeightsFile(path, &file), "the weights of a generator");
  requireRead(path, generatorFromWeights(file, &data), "the weights of a generator");
  if (data.basis.input == GeneratorInput::samples) return false;
  basis->data = std::move(data.basis);
  return true;
}

void fitBasis(const Request& request, const PcaOptions& options, const OptionTable& table) {
  std::vector<std::string> read = request.shards;
  read.insert(read.end(), request.held_out.begin(), request.held_out.end());
  read.push_back(request.from);
  refuseToReplace(request.out, read, kBasisFiles);
  requireOutputFile(request.out);
  // of which is measured how much the basis keeps of functions that it has not seen
  FunctionSet held_out;
  if (!request.held_out.empty()) {
    held_out = readFunctionSet(request.held_out, supportPattern().hash, kSupportPointCount);
    if (held_out.functionCount() == 0) {
      throw InputError(request.held_out.front(), "functions", "at least one in all held-out shards", "none");
    }
  }
  BasisFit fit;
  MeanFunction mean;
  std::map<std::string, std::string> inputs;
  std::string hashes;
  DuplicateFilter filter;
  Progress progress("shards", static_cast<int64_t>(request.shards.size()));
  for (size_t i = 0; i < request.shards.size(); ++i) {
    Shard shard = readShard(request.shards[i], supportPattern().hash, kSupportPointCount);
    // functions that an earlier shard holds count once
    filter.removeKnown(&shard);
    fit.add(shard.phi.data(), shard.functionCount());
    mean.add(shard);
    hashes += fileSha256(request.shards[i]);
    progress.update(static_cast<int64_t>(i + 1));
  }
  if (fit.functionCount() < static_cast<uint64_t>(options.components)) {
    std::cerr << "nlg-pca: only " << fit.functionCount() << " functions for " << options.components
              << " components; the basis holds as many as the functions span\n";
  }
  const std::vector<int> counts = {32, 64, 128, 256, 512, 1024};
  BasisFile file;
  // wide enough for the table of variance kept; the file takes its first components
  Basis wide = fit.fit(std::max(counts.back(), options.components));
  bool is_taken = false;
  if (!request.from.empty()) {
    is_taken = takeBasis(request.from, &wide);
    if (is_taken) inputs["weights"] = fileSha256(request.from);
  }
  if (held_out.functionCount() > 0) {
    file.kept_variance = keptVariance(wide, held_out.phi.data(), held_out.functionCount(), counts);
    file.kept_counts.assign(counts.begin(), counts.end());
  }
  file.basis = is_taken ? wide : truncateBasis(wide, options.components);
  file.pattern_hash = supportPattern().hash;
  mean.finish(&file);
  inputs["training_set"] = sha256(hashes);
  file.provenance_json = provenance("nlg-pca", table.toJson(), inputs).dump();
  writeBasisFile(request.out, file);

  nlohmann::ordered_json result = {{"functions", fit.functionCount()},
                                   {"components", file.basis.data.coefficientCount()},
                                   {"class_count", file.basis.data.class_count}};
  for (size_t i = 0; i < file.kept_counts.size(); ++i) {
    result["held_out_variance_kept"][std::to_string(file.kept_counts[i])] = file.kept_variance[i];
  }
  std::vector<double> spectrum = wide.spectrum;
  std::sort(spectrum.begin(), spectrum.end(), std::greater<>());
  spectrum.resize(2048);
  // programs draw it; people need not read 2,048 numbers
  if (::isatty(STDOUT_FILENO) != 1) result["spectrum"] = spectrum;
  std::cout << result.dump() << '\n';
}

nlohmann::ordered_json describeBasis(const std::string& path) {
  const BasisFile file = readBasisFile(path);
  nlohmann::ordered_json json = {{"functions", file.basis.function_count},
                                 {"components", file.basis.data.coefficientCount()},
                                 {"class_count", file.basis.data.class_count}};
  for (size_t i = 0; i < file.kept_counts.size(); ++i)
    json["held_out_variance_kept"][std::to_string(file.kept_counts[i])] = file.kept_variance[i];
  json["pattern_hash"] = fmt::format("{:016x}", file.pattern_hash);
  json["verified"] = kVerifiedByDigest;
  json["origin"] = parsedOrText(file.provenance_json);
  return json;
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "info") == 0)
    return nlg::fileInfoMain(argc - 1, argv + 1, {"nlg-pca info", "bases (.h5)", "basis", nlg::describeBasis});
  CLI::App app{
      "Fits the PCA basis of the weighting functions in a training set.\n"
      "nlg-pca info FILE ...: verifies and describes bases.",
      "nlg-pca"};
  nlg::Request request;
  nlg::PcaOptions options;
  nlg::OptionTable table("basis");
  table.add("components", &options.components, "number of components (K), which are the generator's inputs", 1, 1024);
  app.add_option("--shards", request.shards, "training shards")->required();
  app.add_option("--held-out", request.held_out, "shards of held-out scenes, for the variance kept");
  app.add_option("--from", request.from,
                 "weights whose basis is written instead of a new one, for nlg-train --init; of weights that read samples a new "
                 "one is written all the same");
  app.add_option("--out", request.out, "basis to write (.h5)")->required();
  nlg::computeBlasOnCallingThreads();
  return nlg::runTool(argc, argv, app, table, [&] { nlg::fitBasis(request, options, table); });
}
