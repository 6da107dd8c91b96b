// nlg-cache: puts the functions of training shards and their coefficients into one shuffled file that nlg-train reads while it trains.

#include <CLI/CLI.hpp>
#include <cstring>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/output_path.h"
#include "train/basis/basis_file.h"
#include "train/generator/data/function_cache.h"
#include "train/generator/data/function_cache_writer.h"

namespace nlg {
namespace {

struct Request {
  std::vector<std::string> shards;
  std::string basis, out;
};

void run(const Request& request) {
  std::vector<std::string> inputs = request.shards;
  inputs.push_back(request.basis);
  refuseToReplace(request.out, inputs, {"a cache", [](std::string_view bytes) {
                                          return bytes.starts_with(std::string_view(kCacheMagic, sizeof kCacheMagic));
                                        }});
  const BasisFile basis = readBasisFile(request.basis);
  const CacheReport report = writeFunctionCache(request.out, request.shards, basis.basis.data, fileSha256(request.basis));
  const nlohmann::ordered_json result = {
      {"functions", report.functions}, {"duplicates", report.duplicates}, {"bytes", report.bytes}};
  std::cout << result.dump() << '\n';
}

nlohmann::ordered_json describeCache(const std::string& path) {
  endWhenPagesVanish("nlg-cache info", path);
  FunctionCache cache(path);
  for (int64_t block = 0; block < cache.blockCount(); ++block) cache.loadBlock(block);
  return {{"functions", cache.functionCount()},
          {"coefficients", cache.coefficientCount()},
          {"scenes", cache.origin().scenes.size()},
          {"basis_sha256", cache.origin().basis_sha256},
          {"training_set_sha256", cache.origin().training_set_sha256},
          {"verified", kVerifiedByDigest}};
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "info") == 0)
    return nlg::fileInfoMain(argc - 1, argv + 1, {"nlg-cache info", "function caches", "cache", nlg::describeCache});
  CLI::App app{
      "Writes a training set as a cache, from which nlg-train reads sets larger than memory.\n"
      "nlg-cache info FILE ...: verifies and describes caches.",
      "nlg-cache"};
  nlg::Request request;
  nlg::OptionTable table("cache");
  app.add_option("--shards", request.shards, "training shards")->required();
  app.add_option("--basis", request.basis, "basis of nlg-pca")->required();
  app.add_option("--out", request.out, "cache to write")->required();
  return nlg::runTool(argc, argv, app, table, [&] { nlg::run(request); });
}
