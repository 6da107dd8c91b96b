#include "tool/command/options.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"

namespace nlg {
namespace {

struct Values {
  int jobs = 2;
  uint64_t seed = 1;
  double spacing_m = 0.5;
  bool cull = true;
  std::string scene = "box", light = "all";
  std::vector<std::string> families = {"rooms"};
};

OptionTable tableOf(Values* values) {
  OptionTable table("datagen");
  table.add("jobs", &values->jobs, "threads", 1, 64);
  table.add("seed", &values->seed, "seed of everything random");
  table.add("spacing_m", &values->spacing_m, "probe spacing, metres", 0.01, 100.0);
  table.add("cull", &values->cull, "skip what nobody sees");
  table.add("scene", &values->scene, "scene file");
  table.add("light", &values->light, "light that is kept", {"all", "lamps", "none"});
  table.add("families", &values->families, "procedural families");
  return table;
}

class Options : public testing::Test {
 protected:
  void readYaml(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    OptionTable table = tableOf(&values_);
    table.readYaml(path_);
  }

  // The message that the text is refused with, the file's name cut off; "no error" when it is not refused.
  std::string refusalOfYaml(const std::string& text) {
    const std::string line = errorOfCall<UsageError>([&] { readYaml(text); });
    return line.rfind(path_, 0) == 0 ? line.substr(path_.size()) : line;
  }

  void parseFlags(const std::vector<std::string>& arguments, OptionTable* table) {
    CLI::App app;
    table->addFlags(app);
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
    app.parse(reversed);
    table->applyFlags();
  }

  std::string refusalOfFlags(const std::vector<std::string>& arguments) {
    OptionTable table = tableOf(&values_);
    return errorOfCall<UsageError>([&] { parseFlags(arguments, &table); });
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "options.yaml";
  Values values_;
};

TEST_F(Options, KeepDefaultsWithoutASection) {
  for (const char* text : {"", "# nothing\n", "name: demo\n", "datagen:\n", "---\n...\n", "datagen: {}\n"}) {
    EXPECT_EQ(refusalOfYaml(text), "no error") << text;
  }
  EXPECT_EQ(values_.jobs, 2);
  EXPECT_EQ(values_.families, std::vector<std::string>{"rooms"});
}

TEST_F(Options, TakeEveryTypeFromYaml) {
  readYaml(
      "name: demo\ntrain: {steps: 5}\ndatagen:\n  jobs: 8\n  seed: 18446744073709551615\n  spacing_m: 2.5e-1\n"
      "  cull: false\n  scene: \"a, b: c\"\n  light: lamps\n  families: [mazes, 'two, words']\n");
  EXPECT_EQ(values_.jobs, 8);
  EXPECT_EQ(values_.seed, 18446744073709551615u);
  EXPECT_EQ(values_.spacing_m, 0.25);
  EXPECT_FALSE(values_.cull);
  EXPECT_EQ(values_.scene, "a, b: c");
  EXPECT_EQ(values_.light, "lamps");
  EXPECT_EQ(values_.families, (std::vector<std::string>{"mazes", "two, words"}));
}

TEST_F(Options, TakeEveryTypeFromFlags) {
  EXPECT_EQ(refusalOfFlags(
                {"--jobs", "8", "--seed=7", "--spacing-m", "1e1", "--cull=false", "--scene", "x y", "--families", "mazes,caves"}),
            "no error");
  EXPECT_EQ(values_.jobs, 8);
  EXPECT_EQ(values_.seed, 7u);
  EXPECT_EQ(values_.spacing_m, 10.0);
  EXPECT_FALSE(values_.cull);
  EXPECT_EQ(values_.scene, "x y");
  EXPECT_EQ(values_.families, (std::vector<std::string>{"mazes", "caves"}));
  EXPECT_EQ(refusalOfFlags({"--cull", "--families", ""}), "no error");
  EXPECT_TRUE(values_.cull);
  EXPECT_TRUE(values_.families.empty());
}

TEST_F(Options, TakeAFlagAsOftenAsItIsGivenWhereAListSaysSo) {
  std::vector<std::string> wishes = {"old"};
  OptionTable table = tableOf(&values_);
  table.addRepeated("wishes", &wishes, "one at a time");
  parseFlags({"--wishes", "a,b c=d", "--jobs", "8", "--wishes=e"}, &table);
  EXPECT_EQ(wishes, (std::vector<std::string>{"a,b c=d", "e"}));
  EXPECT_THROW(parseFlags({"--wishes", ""}, &table), UsageError);
}

TEST_F(Options, PreferFlagsToYamlToDefaults) {
  OptionTable table = tableOf(&values_);
  CLI::App app;
  table.addFlags(app);
  app.parse(std::vector<std::string>{"4", "--jobs"});
  std::ofstream(path_) << "datagen: {jobs: 8, seed: 9}\n";
  table.readYaml(path_);
  EXPECT_EQ(values_.jobs, 8) << "flags are only remembered until applyFlags";
  table.applyFlags();
  EXPECT_EQ(values_.jobs, 4) << "flag";
  EXPECT_EQ(values_.seed, 9u) << "yaml";
  EXPECT_EQ(values_.spacing_m, 0.5) << "default";
}

TEST_F(Options, PassedFromAnotherSectionAreFlagsAlone) {
  OptionTable table = tableOf(&values_);
  int walks = 3;
  table.passedFrom("validate_light");
  table.add("walks", &walks, "walks in air", 1, 9);
  EXPECT_FALSE(table.toJson().contains("walks"));
  EXPECT_EQ(table.describeAsJson().back()["section"], "validate_light");
  std::ofstream(path_) << "datagen: {walks: 4}\n";
  EXPECT_THROW(table.readYaml(path_), UsageError);
  std::ofstream(path_) << "validate_light: {walks: 4}\n";
  table.readYaml(path_);
  parseFlags({"--walks", "5"}, &table);
  EXPECT_EQ(walks, 5);
}

TEST_F(Options, FlagsAloneAreOfOneRunAndOfItsProvenance) {
  OptionTable table = tableOf(&values_);
  std::vector<double> spacings;
  bool words = false;
  table.flagsAlone();
  table.add("spacings", &spacings, "finest spacings, metres", 0.01, 10.0);
  table.add("words", &words, "words too");
  for (const auto& option : table.describeAsJson()) EXPECT_NE(option["name"], "spacings");
  EXPECT_FALSE(table.toJson().contains("words"));
  std::ofstream(path_) << "datagen: {words: true}\n";
  EXPECT_THROW(table.readYaml(path_), UsageError);
  parseFlags({"--spacings", "1", "0.5", "--words"}, &table);
  EXPECT_EQ(spacings, (std::vector<double>{1.0, 0.5}));
  const nlohmann::ordered_json used = table.usedJson({"jobs"});
  EXPECT_EQ(used["spacings"], spacings);
  EXPECT_EQ(used["words"], true);
  EXPECT_FALSE(used.contains("jobs"));
  EXPECT_TRUE(used.contains("seed"));
  for (const char* bad : {"0", "11", "nan", "1m"}) EXPECT_THROW(parseFlags({"--spacings", bad}, &table), UsageError) << bad;
}

TEST_F(Options, RefuseValuesWithLineAndColumn) {
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"datagen:\n  jobs: 65\n", ":2:9: jobs: expected an integer in [1, 64], got '65'"},
      {"datagen:\n  jobs: 99999999999999999999\n", ":2:9: jobs: expected an integer in [1, 64], got '99999999999999999999'"},
      {"datagen:\n  jobs:\n", ":2:3: jobs: expected an integer in [1, 64], got nothing"},
      {"datagen:\n  jobs: [1]\n", ":2:9: jobs: expected an integer in [1, 64], got a sequence"},
      {"datagen:\n  scene: \"a\\0b\"\n", ":2:10: scene: expected a text, got 'a\\x00b'"},
      {"datagen:\n  seed: 18446744073709551616\n", ":2:9: seed: expected an unsigned 64-bit integer, got '18446744073709551616'"},
      {"datagen:\n  spacing_m: .nan\n", ":2:14: spacing_m: expected a finite number in [0.01, 100], got '.nan'"},
      {"datagen:\n  spacing_m: 1 m\n", ":2:14: spacing_m: expected a finite number in [0.01, 100], got '1 m'"},
      {"datagen:\n  spacing_m: 0.001\n", ":2:14: spacing_m: expected a finite number in [0.01, 100], got '0.001'"},
      {"datagen:\n  cull: yes\n", ":2:9: cull: expected true or false, got 'yes'"},
      {"datagen:\n  light: suns\n", ":2:10: light: expected all, lamps or none, got 'suns'"},
      {"datagen:\n  families: [a, '']\n", ":2:17: families: expected a list of texts, none empty, got ''"},
      {"datagen:\n  families: [a, [b]]\n", ":2:17: families: expected a list of texts, none empty, got a sequence"},
      {"datagen:\n  scene: !!binary aGk=\n", ":2:10: scene: expected a text without a tag, got 'tag:yaml.org,2002:binary'"},
      {"datagen: 5\n", ":1:10: expected a map of keys and values, got '5'"},
      {"- datagen\n", ":1:1: expected a map of keys and values, got a sequence"},
  };
  for (const auto& [text, refusal] : cases) EXPECT_EQ(refusalOfYaml(text), refusal) << text;
}

TEST_F(Options, RefuseUnknownAndRepeatedKeysWithLineAndColumn) {
  const std::string keys = "expected one of [jobs, seed, spacing_m, cull, scene, light, families], got ";
  std::string sections = "expected one of [";
  for (const std::string& section : pipelineSections()) sections += (sections.back() == '[' ? "" : ", ") + section;
  sections += "], got ";
  EXPECT_EQ(refusalOfYaml("datagen:\n  spacing: 1\n"), ":2:3: " + keys + "'spacing' (did you mean 'spacing_m'?)");
  EXPECT_EQ(refusalOfYaml("datagen:\n  sede: 1\n"), ":2:3: " + keys + "'sede'");
  EXPECT_EQ(refusalOfYaml("datagen:\n  xyzzy: 1\n"), ":2:3: " + keys + "'xyzzy'");
  EXPECT_EQ(refusalOfYaml("name: x\n\ndatagne: {}\n"), ":3:1: " + sections + "'datagne' (did you mean 'datagen'?)");
  EXPECT_EQ(refusalOfYaml("datagen:\n  jobs: 1\n  jobs: 1\n"), ":3:3: expected each key once, got 'jobs' again");
  EXPECT_EQ(refusalOfYaml("datagen: {}\ndatagen: {}\n"), ":2:1: expected each key once, got 'datagen' again");
  EXPECT_EQ(refusalOfYaml("datagen:\n  [1, 2]: 1\n"), ":2:3: expected a key, got a sequence");
  EXPECT_EQ(refusalOfYaml("datagen:\n  <<: {jobs: 3}\n").substr(0, 6), ":2:3: ");
}

TEST_F(Options, RefuseAMissingOrHugeFileAsInput) {
  OptionTable table = tableOf(&values_);
  EXPECT_THROW(table.readYaml("/nowhere/pipeline.yaml"), InputError);
  EXPECT_THROW(readYaml(std::string((1 << 20) + 1, '#')), InputError);
}

TEST_F(Options, RefuseFlagsInTheWordsOfYaml) {
  EXPECT_EQ(refusalOfFlags({"--jobs", "65"}), "--jobs: expected an integer in [1, 64], got '65'");
  EXPECT_EQ(refusalOfFlags({"--jobs", ""}), "--jobs: expected an integer in [1, 64], got ''");
  EXPECT_EQ(refusalOfFlags({"--seed", "-1"}), "--seed: expected an unsigned 64-bit integer, got '-1'");
  EXPECT_EQ(refusalOfFlags({"--spacing-m", "nan"}), "--spacing-m: expected a finite number in [0.01, 100], got 'nan'");
  EXPECT_EQ(refusalOfFlags({"--cull=maybe"}), "--cull: expected true or false, got 'maybe'");
  EXPECT_EQ(refusalOfFlags({"--families", "a,,b"}), "--families: expected a list of texts, none empty, got ''");
  EXPECT_EQ(refusalOfFlags({"--families", "a,"}), "--families: expected a list of texts, none empty, got ''");
}

}  // namespace
}  // namespace nlg
