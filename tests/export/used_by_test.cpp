// The weights of one baked scene.

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include <nlohmann/json.hpp>

#include "export/used_by/used_by.h"
#include "nlg/light_grid.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tests/runtime_eval/sample_generator.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

class UsedBy : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }
  std::string write(const std::string& name, const std::string& bytes) const { return folder_.write(name, bytes); }
  static Representation named(const std::string& name) {
    Representation representation;
    EXPECT_TRUE(findRepresentation(name, &representation)) << name;
    return representation;
  }
  // Weights of a representation, under a name that does not say which.
  std::string writeWeights(const std::string& file, const std::string& representation, uint64_t seed = 1) const {
    return write(file, serializeWeights(weightsFromGenerator(sampleGenerator(named(representation), 16, 2, seed))));
  }
  // The light grid of one cell whose probes have functions of these representations.
  std::string writeGrid(const std::vector<std::string>& used, const std::map<std::string, std::string>& inputs) const {
    LightGrid grid;
    ProbeTreeFrame frame;
    frame.root_count = {1, 1, 1};
    EXPECT_EQ(ProbeTree::build(
                  frame, [](const ProbeCell&) { return CellVerdict::fits; }, 100, &grid.tree),
              ProbeTreeStatus::ok);
    grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
    for (size_t i = 0; i < used.size(); ++i) {
      grid.representations.push_back(named(used[i]));
      grid.representations.back().slope = 0.05f;
      const std::vector<float> theta(grid.representations.back().thetaCount(), 0.5f);
      grid.probe_function[i] = grid.addFunction(static_cast<uint8_t>(i), theta.data());
    }
    std::string bytes;
    const GridMetadata metadata = {{"scene", "level"}, {"provenance", provenance("nlg-bake", {}, inputs).dump()}};
    const FileResult result = serializeLightGrid(grid, {ThetaPrecision::float32}, metadata, &bytes);
    EXPECT_TRUE(result.ok()) << result.detail;
    return write("grid.safetensors", bytes);
  }
  // Three weights, of which the grid has functions of the first and the last.
  void makeBake() {
    weights_ = {writeWeights("a.safetensors", "tent_mlp"), writeWeights("b.safetensors", "mlp"),
                writeWeights("c.safetensors", "pf5")};
    hash_ = {{"tent_mlp", fileSha256(weights_[0])}, {"mlp", fileSha256(weights_[1])}, {"pf5", fileSha256(weights_[2])}};
    std::map<std::string, std::string> inputs = {{"scene", "0123"}};
    for (const auto& [name, sha256] : hash_) inputs["weights of " + name] = sha256;
    grid_ = writeGrid({"tent_mlp", "pf5"}, inputs);
  }
  std::vector<BakeWeights> choose() const { return weightsUsedBy(readBakedWeights(grid_), grid_, weights_); }

  static int forBake(const std::vector<std::string>& arguments) {
    std::vector<std::string> texts = {"used-by"};
    texts.insert(texts.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& text : texts) argv.push_back(text.data());
    return usedByMain(static_cast<int>(argv.size()), argv.data());
  }

  const TemporaryFolder folder_;
  std::string grid_;
  std::vector<std::string> weights_;
  std::map<std::string, std::string> hash_;
};

TEST_F(UsedBy, CopiesThoseThatFunctionsUseByteForByteAndCountsTheRest) {
  makeBake();
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = forBake({"--bake", grid_, "--weights", weights_[0], weights_[1], weights_[2], "--out", path("scene")});
  const std::string out = testing::internal::GetCapturedStdout(), said = testing::internal::GetCapturedStderr();
  ASSERT_EQ(code, 0) << said;
  EXPECT_TRUE(readFile(path("scene/tent_mlp.safetensors")) == readFile(weights_[0]));
  EXPECT_TRUE(readFile(path("scene/pf5.safetensors")) == readFile(weights_[2]));
  EXPECT_EQ(std::distance(fs::directory_iterator(path("scene")), fs::directory_iterator()), 2);
  const nlohmann::json line = nlohmann::json::parse(out);
  EXPECT_EQ(line.at("scene"), "level");
  EXPECT_EQ(line.at("written").size(), 2u);
  EXPECT_EQ(line.at("left_out").size(), 1u);
  EXPECT_EQ(line.at("left_out")[0].at("representation"), "mlp");
  EXPECT_EQ(line.at("bytes_left_out"), fs::file_size(weights_[1]));
  EXPECT_EQ(line.at("bytes_written"), fs::file_size(weights_[0]) + fs::file_size(weights_[2]));
  EXPECT_NE(said.find("b.safetensors"), std::string::npos) << said;
  EXPECT_NE(said.find(std::to_string(fs::file_size(weights_[1])) + " bytes"), std::string::npos) << said;
}

TEST_F(UsedBy, ReadsFromAReportWhatItReadsFromTheLightGrid) {
  makeBake();
  nlohmann::json report = {{"scene", "level"}, {"representations", {{"tent_mlp", 3}, {"mlp", 0}, {"pf5", 1}}}};
  for (const auto& [name, sha256] : hash_) report["weights"][name] = {{"sha256", sha256}, {"bytes", 1}};
  const BakedWeights of_report = readBakedWeights(write("report.json", report.dump())), of_grid = readBakedWeights(grid_);
  EXPECT_EQ(of_report.scene, of_grid.scene);
  EXPECT_EQ(of_report.sha256, of_grid.sha256);
  EXPECT_EQ(std::set<std::string>(of_report.used.begin(), of_report.used.end()),
            std::set<std::string>(of_grid.used.begin(), of_grid.used.end()));
}

TEST_F(UsedBy, RefusesToLeaveAFunctionWithoutItsWeights) {
  makeBake();
  weights_.pop_back();
  EXPECT_THROW(choose(), InputError);
}

TEST_F(UsedBy, ReplacesNoInputAndLeavesNoOtherWeightsBesideItsCopies) {
  makeBake();
  fs::rename(weights_[0], path("tent_mlp.safetensors"));
  weights_[0] = path("tent_mlp.safetensors");
  EXPECT_THROW(copyUsedWeights(choose(), grid_, folder_.string()), UsageError);
  // a folder of an earlier bake that used more
  fs::create_directories(path("scene"));
  write("scene/mlp.safetensors", "old");
  EXPECT_THROW(copyUsedWeights(choose(), grid_, path("scene")), UsageError);
  EXPECT_FALSE(fs::exists(path("scene/tent_mlp.safetensors"))) << "refused after the first copy";
}

}  // namespace
}  // namespace nlg
