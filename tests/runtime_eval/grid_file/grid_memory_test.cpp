// Files that say much in little: what a reader makes of them is no more than their bytes stand for, and honest grids are written so that
// they are read.
#include "runtime_eval/grid_file/tensor_reading.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include <nlohmann/json.hpp>

#include "runtime_eval/light_grid/packed_light.h"
#include "runtime_eval/weights_file/tensor_file.h"
#include "tests/runtime_eval/light_grid/random_grid.h"

namespace nlg {
namespace {

constexpr uint64_t kMegabyte = 1'000'000;
// what any file of less than 1 MB may take
constexpr uint64_t kMostOfSmall = 64 * kMegabyte;

uint64_t statusBytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::string word;
  uint64_t kib = 0;
  while (status >> word) {
    if (word == key && status >> kib) return kib * 1024;
  }
  return 0;
}

struct Reading {
  bool is_ok = false;
  uint64_t bytes = 0;  // of memory at most, beside what there was
  std::string detail;
};

// In a process of its own, which has nothing that it could use again.
Reading readingOf(const std::string& file) {
  int pipe[2];
  EXPECT_EQ(::pipe(pipe), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << 5;  // the peak of before
    const uint64_t before = statusBytes("VmRSS:");
    LightGrid grid;
    GridMetadata metadata;
    const FileResult result = parseLightGrid(file, &grid, &metadata);
    const std::string line = std::to_string(statusBytes("VmHWM:") - before) + ' ' + (result.ok() ? "+" : "-") + result.detail;
    static_cast<void>(!::write(pipe[1], line.data(), line.size()));
    ::_exit(0);
  }
  ::close(pipe[1]);
  std::string line(4096, '\0');
  line.resize(static_cast<size_t>(std::max<ssize_t>(0, ::read(pipe[0], line.data(), line.size()))));
  ::close(pipe[0]);
  ::waitpid(child, nullptr, 0);
  const size_t blank = line.find(' ');
  EXPECT_NE(blank, std::string::npos) << "the reader died";
  return {line.substr(blank + 1, 1) == "+", std::stoull(line), line.substr(blank + 2)};
}

std::string bytesOf(const LightGrid& grid) {
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, {ThetaPrecision::int8, kLeastLightError}, {}, &bytes);
  EXPECT_TRUE(result.ok()) << result.detail;
  return bytes;
}

// The file as somebody would write it who wants to say the most in the least: without the room that a writer leaves.
std::string withoutRoom(const std::string& file) {
  TensorFileReader reader;
  EXPECT_TRUE(reader.openBytes(file).ok());
  uint64_t length = 0;
  std::memcpy(&length, file.data(), sizeof length);
  const nlohmann::json header = nlohmann::json::parse(file.substr(8, length));
  std::map<std::string, std::vector<uint8_t>> bytes;
  std::map<std::string, std::vector<int8_t>> signed_bytes;
  std::map<std::string, std::vector<int32_t>> integers;
  std::map<std::string, std::vector<uint32_t>> words;
  std::map<std::string, std::vector<float>> floats;
  std::map<std::string, std::vector<double>> doubles;
  std::map<std::string, std::vector<Half>> halves;
  TensorFileWriter writer;
  const auto copy = [&](const std::string& name, auto& values) {
    EXPECT_TRUE(reader.read(name, &values[name]).ok()) << name;
    writer.add(name, values[name]);
  };
  for (const auto& [name, tensor] : header.items()) {
    if (name == "__metadata__" || name == "room" || name.starts_with("padding")) continue;
    const std::string dtype = tensor.at("dtype");
    if (dtype == "U8") copy(name, bytes);
    if (dtype == "I8") copy(name, signed_bytes);
    if (dtype == "I32") copy(name, integers);
    if (dtype == "U32") copy(name, words);
    if (dtype == "F32") copy(name, floats);
    if (dtype == "F64") copy(name, doubles);
    if (dtype == "F16") copy(name, halves);
  }
  std::string small;
  EXPECT_TRUE(writer.serialize(reader.metadata(), &small).ok());
  return small;
}

// So many roots in a row, cut down to cells of one size.
LightGrid gridOf(int roots, int32_t cell, CellVerdict verdict = CellVerdict::fits) {
  LightGrid grid;
  const CellJudge judge = [=](const ProbeCell& at) { return at.side > cell ? CellVerdict::too_coarse : verdict; };
  EXPECT_EQ(ProbeTree::build({{0, 0, 0}, 1.0, {roots, 1, 1}}, judge, kMaxTreeProbes, &grid.tree), ProbeTreeStatus::ok);
  grid.probe_function.assign(grid.tree.probeCount(), kFreeSpace);
  return grid;
}

LightGrid darkGrid(int roots, size_t groups) {
  LightGrid grid = gridOf(roots, 4);
  grid.light.assign(grid.tree.probeCount() * kShFloats, 0.0f);
  for (size_t g = 0; g < groups; ++g) grid.groups.push_back({"group " + std::to_string(g), grid.light});
  return grid;
}

// All probes alike but one: their records are in no bytes, and take as long to read as others.
LightGrid alikeGrid(int roots, size_t groups) {
  LightGrid grid = darkGrid(roots, 0);
  const std::vector<float> of_one = randomLight(40, 1);
  for (size_t i = 0; i < grid.light.size(); ++i) grid.light[i] = of_one[i < of_one.size() ? i : i % kShFloats];
  for (size_t g = 0; g < groups; ++g) grid.groups.push_back({"group " + std::to_string(g), grid.light});
  if (groups > 0) EXPECT_TRUE(mixLight(startingColours(grid), &grid).ok());
  return grid;
}

LightGrid gridOfShortCodes(int roots, size_t functions) {
  LightGrid grid = gridOf(roots, 4);
  grid.representations = {Representation::code(sampleDictionary(9, 64, 4))};
  const std::vector<float> none(64, 0.0f);
  for (size_t f = 0; f < functions; ++f) grid.probe_function[f % grid.probe_function.size()] = grid.addFunction(0, none.data());
  return grid;
}

LightGrid gridOfDictionaries(size_t count) {
  LightGrid grid = gridOf(1, 16);
  for (size_t r = 0; r < count; ++r) grid.representations.push_back(Representation::code(sampleDictionary(9, 128, 1)));
  return grid;
}

TEST(GridMemory, IsNoMoreThanAFilesBytesStandFor) {
  const std::pair<const char*, std::function<LightGrid()>> hostile[] = {
      {"probes", [] { return gridOf(4, 1); }},
      {"probes of darkness", [] { return darkGrid(60, 0); }},
      {"groups of darkness", [] { return darkGrid(10, 16); }},
      {"numbers of probes that are alike", [] { return alikeGrid(4, 16); }},
      {"codes of no length", [] { return gridOfShortCodes(8, 30000); }},
      {"dictionaries", [] { return gridOfDictionaries(250); }},
  };
  for (const auto& [name, make] : hostile) {
    const std::string honest = bytesOf(make()), file = withoutRoom(honest);
    ASSERT_LT(file.size(), kMegabyte) << name;
    const Reading read = readingOf(file);
    EXPECT_FALSE(read.is_ok) << name << ": " << file.size() << " bytes take " << read.bytes;
    EXPECT_LT(read.bytes, kMostOfSmall) << name;
    EXPECT_TRUE(readingOf(honest).is_ok) << name << ": what is written is read";
  }
}

TEST(GridMemory, WhatIsReadOfASmallFileTakesNoMore) {
  const std::pair<const char*, std::function<LightGrid()>> most[] = {
      {"probes", [] { return gridOf(2, 1); }},
      {"probes of darkness", [] { return darkGrid(40, 0); }},
      {"groups of darkness", [] { return darkGrid(4, 16); }},
      {"numbers of probes that are alike", [] { return alikeGrid(2, 16); }},
      {"codes of no length", [] { return gridOfShortCodes(8, 16000); }},
      {"dictionaries", [] { return gridOfDictionaries(60); }},
  };
  for (const auto& [name, make] : most) {
    const std::string file = bytesOf(make());
    ASSERT_LT(file.size(), kMegabyte) << name;
    const Reading read = readingOf(file);
    EXPECT_TRUE(read.is_ok) << name << ": " << read.detail;
    EXPECT_GT(read.bytes, 10 * kMegabyte) << name << ": no measure of the most";
    EXPECT_LT(read.bytes, kMostOfSmall) << name;
  }
}

}  // namespace
}  // namespace nlg
