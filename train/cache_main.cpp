// nlg-cache: puts the functions of training shards and their coefficients into one shuffled file that nlg-train reads while it trains.

#include <CLI/CLI.hpp>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/tool_main.h"
#include "train/basis/basis_file.h"
#include "train/generator/function_cache_writer.h"

namespace nlg {
namespace {

struct Request {
  std::vector<std::string> shards;
  std::string basis, out;
};

void run(const Request& request) {
  std::vector<std::string> inputs = request.shards;
  inputs.push_back(request.basis);
  refuseToReplaceInputs(request.out, inputs);
  const BasisFile basis = readBasisFile(request.basis);
  const CacheReport report = writeFunctionCache(request.out, request.shards, basis.basis.data, fileSha256(request.basis));
  const nlohmann::ordered_json result = {
      {"functions", report.functions}, {"duplicates", report.duplicates}, {"bytes", report.bytes}};
  std::cout << result.dump() << '\n';
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  CLI::App app{"Makes the cache that nlg-train reads a training set from, whatever its size.", "nlg-cache"};
  nlg::Request request;
  nlg::OptionTable table("cache");
  app.add_option("--shards", request.shards, "training shards")->required();
  app.add_option("--basis", request.basis, "the basis of nlg-pca")->required();
  app.add_option("--out", request.out, "the cache to write")->required();
  return nlg::runTool(argc, argv, app, table, [&] { nlg::run(request); });
}
