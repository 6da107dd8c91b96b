#include "bake/load_generators.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

class DefaultWeightsTest : public testing::Test {
 protected:
  DefaultWeightsTest() {
    fs::create_directories(folder_ / "first");
    fs::create_directories(folder_ / "second");
  }

  std::string put(const std::string& name) const { return folder_.write(name, "x"); }
  std::vector<std::string> folders() const { return {folder_ / "first", folder_ / "second"}; }
  std::string refusal(const std::vector<std::string>& representations) const {
    return errorOfCall<UsageError>([&] { shippedWeights(representations, folders()); });
  }

  const TemporaryFolder folder_;
};

TEST_F(DefaultWeightsTest, TakesTheFirstFolderThatHasThem) {
  const std::string second = put("second/tent_mlp.safetensors");
  EXPECT_EQ(shippedWeights({"tent_mlp"}, folders()), (std::vector{second}));
  const std::string first = put("first/tent_mlp.safetensors"), field = put("first/pf5.safetensors");
  EXPECT_EQ(shippedWeights({"tent_mlp"}, folders()), (std::vector{first}));
  EXPECT_EQ(shippedWeights({"pf5", "tent_mlp"}, folders()), (std::vector{field, first}));
}

TEST_F(DefaultWeightsTest, WantsARepresentation) {
  EXPECT_NE(refusal({}).find("expected at least one of mlp"), std::string::npos) << refusal({});
}

TEST_F(DefaultWeightsTest, SaysWhereItLookedForWhat) {
  const std::string text = refusal({"tent_mlp"});
  for (const std::string& part : {folders()[0], folders()[1], std::string("tent_mlp.safetensors"), std::string("--weights")}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  EXPECT_NE(refusal({"tent"}).find("'tent'"), std::string::npos);
}

// Halves of two sets would be weights that were never measured together.
TEST_F(DefaultWeightsTest, DoesNotMixFolders) {
  put("first/tent_mlp.safetensors");
  put("second/pf5.safetensors");
  EXPECT_NE(refusal({"tent_mlp", "pf5"}).find(folder_ / "first/pf5.safetensors"), std::string::npos);
}

TEST_F(DefaultWeightsTest, TheVariableNamesTheOnlyFolder) {
  ::setenv("NLG_WEIGHTS", "/somewhere", 1);
  EXPECT_EQ(weightsFolders(), (std::vector<std::string>{"/somewhere"}));
  ::unsetenv("NLG_WEIGHTS");
  const std::vector<std::string> folders = weightsFolders();
  ASSERT_EQ(folders.size(), 1u);
  EXPECT_TRUE(folders[0].ends_with("share/neural-light-grid/weights")) << folders[0];
  // this test lies in the build folder
  EXPECT_TRUE(fs::is_regular_file(fs::path(folders[0]) / "README.md")) << folders[0];
}

}  // namespace
}  // namespace nlg
