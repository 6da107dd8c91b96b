#include "tool/command/tool_main.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <new>

#include "tool/provenance.h"

namespace nlg {
namespace {

struct Outcome {
  int code;
  std::string out, err;
};

// Runs the tool "nlg-pca" with one option, "jobs", and what it does when the command line was good.
Outcome runWith(
    std::vector<std::string> arguments, const std::function<void(int jobs)>& body = [](int) {}) {
  int jobs = 2;
  CLI::App app("projects functions", "nlg-pca");
  OptionTable table("basis");
  table.add("jobs", &jobs, "threads", 1, 64);
  arguments.insert(arguments.begin(), "/usr/bin/whatever");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = runTool(static_cast<int>(argv.size()), argv.data(), app, table, [&] { body(jobs); });
  return {code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

int codeOf(ExitCode code) { return static_cast<int>(code); }

TEST(RunTool, EndsEveryErrorWithItsCodeAndOneLine) {
  const auto expectEnd = [](const std::function<void(int)>& body, ExitCode code, const std::string& line) {
    const Outcome outcome = runWith({}, body);
    EXPECT_EQ(outcome.code, codeOf(code)) << line;
    EXPECT_EQ(outcome.err, line);
  };
  expectEnd([](int) {}, ExitCode::success, "");
  expectEnd([](int) { throw UsageError("--x", "a", "b"); }, ExitCode::usage_error, "nlg-pca: error: --x: expected a, got b\n");
  expectEnd([](int) { throw InputError("f", "byte 1", "a", "b"); }, ExitCode::input_error,
            "nlg-pca: error: f: byte 1: expected a, got b\n");
  expectEnd([](int) { throw NumericalError("train", "step 3", "loss", 0.5); }, ExitCode::numerical_error,
            "nlg-pca: error: train: step 3: loss is 0.500000\n");
  expectEnd([](int) { throw OutputError("f", "no"); }, ExitCode::output_error, "nlg-pca: error: f: cannot be written: no\n");
  expectEnd([](int) { throw CheckFailed("parity", "0", "1"); }, ExitCode::check_failed,
            "nlg-pca: error: parity: expected 0, got 1\n");
  expectEnd([](int) { throw std::bad_alloc(); }, ExitCode::internal_error, "nlg-pca: error: out of memory\n");
  expectEnd([](int) { throw std::runtime_error("two\nlines\n"); }, ExitCode::internal_error, "nlg-pca: error: two lines\n");
  expectEnd([](int) { throw InputError("f", "name", "text", "\x1b[2J\t\x7f"); }, ExitCode::input_error,
            "nlg-pca: error: f: name: expected text, got  [2J  \n");
  expectEnd([](int) { throw 5; }, ExitCode::internal_error, "nlg-pca: error: unknown exception\n");
}

TEST(RunTool, EndsHelpAndVersionWithSuccessAndWithoutRunning) {
  const auto mustNotRun = [](int) { FAIL() << "ran"; };
  const Outcome help = runWith({"--help"}, mustNotRun);
  EXPECT_EQ(help.code, 0);
  EXPECT_NE(help.out.find("--config"), std::string::npos) << help.out;
  EXPECT_NE(help.out.find("--jobs"), std::string::npos) << help.out;
  const Outcome version = runWith({"--version"}, mustNotRun);
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out, std::string(sourceRevision()) + "\n");
  EXPECT_EQ(help.err + version.err, "");
}

TEST(RunTool, ListsItsFlagsOneALine) {
  const Outcome outcome = runWith({"--list-flags"}, [](int) { FAIL() << "it runs"; });
  EXPECT_EQ(outcome.code, codeOf(ExitCode::success));
  for (const std::string flag : {"help", "help-all", "config", "version", "jobs"})
    EXPECT_NE(("\n" + outcome.out).find("\n--" + flag + "\n"), std::string::npos) << flag;
}

TEST(RunTool, EndsCommandLineMistakesAsUsageErrors) {
  const std::vector<std::vector<std::string>> mistakes = {
      {"--nonsense"}, {"stray"}, {"--jobs"}, {"--jobs", "x"}, {"--jobs", "0"}, {"--jobs=", "3"}, {"--jobs", "1", "--jobs", "2"},
      {"--config"}};
  for (const auto& arguments : mistakes) {
    const Outcome outcome = runWith(arguments, [](int) { FAIL() << "ran"; });
    EXPECT_EQ(outcome.code, codeOf(ExitCode::usage_error)) << arguments[0] << ": " << outcome.err;
    EXPECT_EQ(outcome.err.rfind("nlg-pca: error: ", 0), 0u) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

// JSON and shards, in which names of scenes travel, hold nothing else.
TEST(RunTool, TakesArgumentsInUtf8Only) {
  const Outcome outcome = runWith({"--jobs", "\xff"});
  EXPECT_EQ(outcome.code, codeOf(ExitCode::usage_error));
  EXPECT_EQ(outcome.err, "nlg-pca: error: argument 2: expected UTF-8, got other bytes\n");
  EXPECT_EQ(runWith({"--jobs", "3", "--config", "Größe.yaml"}).code, codeOf(ExitCode::input_error));
}

TEST(RunTool, PrintsNothingThatSteersATerminal) {
  const Outcome outcome = runWith({}, [](int) { std::cerr << "a level of \033[2J\ttwo\nlines\xc2\x9b" << std::flush; });
  EXPECT_EQ(outcome.err, "a level of  [2J\ttwo\nlines ");
  EXPECT_EQ(outcome.code, 0);
}

TEST(RunTool, ReadsItsSectionAndPrefersFlags) {
  const std::string path = (std::filesystem::temp_directory_path() / ("nlg_main_" + std::to_string(::getpid()))).string();
  std::ofstream(path) << "basis: {jobs: 7}\ntrain: {jobs: 9}\n";
  int seen = 0;
  const auto remember = [&](int jobs) { seen = jobs; };
  EXPECT_EQ(runWith({"--config", path}, remember).code, 0);
  EXPECT_EQ(seen, 7);
  EXPECT_EQ(runWith({"--jobs", "5", "--config", path}, remember).code, 0);
  EXPECT_EQ(seen, 5);
  EXPECT_EQ(runWith({}, remember).code, 0);
  EXPECT_EQ(seen, 2);
  std::ofstream(path) << "basis: {jobs: 65}\n";
  EXPECT_EQ(runWith({"--config", path}).err,
            "nlg-pca: error: " + path + ":1:15: jobs: expected an integer in [1, 64], got '65'\n");
  std::filesystem::remove(path);
  EXPECT_EQ(runWith({"--config", path}).code, codeOf(ExitCode::input_error));
  EXPECT_EQ(runWith({"--config", ""}).code, codeOf(ExitCode::input_error));
}

TEST(RunTool, SurvivesAClosedPipe) {
  const Outcome outcome = runWith({}, [](int) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    ::close(ends[0]);
    EXPECT_EQ(::write(ends[1], "x", 1), -1);
    EXPECT_EQ(errno, EPIPE);
    ::close(ends[1]);
  });
  EXPECT_EQ(outcome.code, 0);
}

TEST(RunTool, EndsALostResultAsOutputError) {
  const Outcome outcome = runWith({}, [](int) { std::cout.setstate(std::ios::badbit); });
  std::cout.clear();
  EXPECT_EQ(outcome.code, codeOf(ExitCode::output_error));
}

TEST(Provenance, HoldsWhatItWasGivenAndNothingElse) {
  const nlohmann::ordered_json options = {{"z", 1}, {"a", 2}};
  const auto json = provenance("nlg-pca", options, {{"dataset", "12ab"}});
  EXPECT_EQ(json.dump(), std::string(R"({"tool":"nlg-pca","revision":")") + sourceRevision() +
                             R"(","options":{"z":1,"a":2},"inputs":{"dataset":"12ab"}})");
  EXPECT_EQ(provenance("t", options, {})["inputs"].dump(), "{}");
}

}  // namespace
}  // namespace nlg
