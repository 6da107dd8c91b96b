
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "runtime_eval/evaluator/kernel_shape.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "runtime_eval/numbers/coded_bytes.h"
#include "runtime_eval/weights_file/safetensors_layout.h"
#include "tests/damage.h"
#include "tests/runtime_eval/light_grid/random_grid.h"
#include "tests/runtime_eval/weights_file/digest_edits.h"

namespace nlg {
namespace {

constexpr GridPrecision kPrecisions[] = {{ThetaPrecision::float32, 0.005},
                                         {ThetaPrecision::float16, std::nullopt},
                                         {ThetaPrecision::int8, std::nullopt},
                                         {ThetaPrecision::float16, 0.02},
                                         {ThetaPrecision::int8, 0.3}};

const GridMetadata kMetadata = {{"scene", "house_3"}, {"options", R"({"tau": 0.02, "note": "é"})"}, {"weights_sha256", "00ff"}};

std::string bytesOf(const LightGrid& grid, const GridPrecision& precision = {ThetaPrecision::float32},
                    const GridMetadata& metadata = kMetadata) {
  std::string bytes;
  const FileResult result = serializeLightGrid(grid, precision, metadata, &bytes);
  EXPECT_TRUE(result.ok()) << result.detail;
  return bytes;
}

// Parses into a grid that holds something; what is refused must leave it empty.
FileResult parse(std::string_view bytes, LightGrid* grid) {
  GridMetadata metadata = kMetadata;
  *grid = {};
  grid->theta = {1.0f};
  const FileResult result = parseLightGrid(bytes, grid, &metadata);
  EXPECT_EQ(result.ok(), result.detail.empty()) << result.detail;
  EXPECT_EQ(result.detail.find('\n'), std::string::npos) << result.detail;
  if (!result.ok()) {
    EXPECT_TRUE(grid->theta.empty() && grid->probe_function.empty() && grid->light.empty() && metadata.empty()) << result.detail;
    EXPECT_EQ(grid->tree.probeCount() + grid->tree.nodeCount(), 0u) << result.detail;
  }
  return result;
}

void expectSameGrid(const LightGrid& a, const LightGrid& b) {
  expectSameTree(a.tree, b.tree);
  EXPECT_EQ(a.probe_function, b.probe_function);
  EXPECT_EQ(a.function_representation, b.function_representation);
  EXPECT_EQ(a.theta_begin, b.theta_begin);
  EXPECT_EQ(a.theta, b.theta);
  EXPECT_EQ(a.light, b.light);
  EXPECT_EQ(a.quads, b.quads);
  ASSERT_EQ(a.function_brick.size(), b.function_brick.size());
  for (size_t i = 0; i < a.function_brick.size(); ++i) EXPECT_EQ(a.function_brick[i].step, b.function_brick[i].step);
  ASSERT_EQ(a.representations.size(), b.representations.size());
  for (size_t i = 0; i < a.representations.size(); ++i) {
    EXPECT_STREQ(representationName(a.representations[i]), representationName(b.representations[i]));
    EXPECT_EQ(a.representations[i].slope, b.representations[i].slope);
  }
}

// Where a tensor's bytes begin in a file, and how many there are, by the format alone.
struct Place {
  size_t begin = 0, count = 0;
};
std::map<std::string, Place> placesIn(const std::string& bytes) {
  uint64_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof length);
  std::map<std::string, Place> places;
  const nlohmann::json header = nlohmann::json::parse(bytes.substr(8, length));
  for (const auto& [name, entry] : header.items()) {
    if (name == "__metadata__") continue;
    const size_t begin = entry["data_offsets"][0], end = entry["data_offsets"][1];
    places[name] = {8 + length + begin, end - begin};
  }
  return places;
}

using Columns = std::vector<uint16_t>;

std::vector<uint8_t> decoded(const std::string& bytes, const std::string& tensor, const Columns& columns = {}) {
  const Place place = placesIn(bytes).at(tensor);
  std::vector<uint8_t> values;
  EXPECT_TRUE(decodeBytes(
      {bytes.begin() + static_cast<ptrdiff_t>(place.begin), bytes.begin() + static_cast<ptrdiff_t>(place.begin + place.count)},
      columns, &values))
      << tensor;
  return values;
}

// Of rows of these lengths, one column for each place in a row.
Columns columnsOf(const std::vector<int>& lengths) {
  Columns columns;
  for (const int length : lengths) {
    for (int i = 0; i < length; ++i) columns.push_back(static_cast<uint16_t>(i));
  }
  return columns;
}

// Of probe.function: four bytes for each probe whose kind says that it has a name.
Columns columnsOfNames(const std::string& bytes) {
  int named = 0;
  for (const uint8_t four : decoded(bytes, "probe.kind")) {
    for (int shift = 0; shift < 8; shift += 2) named += (four >> shift & 3) == 3;
  }
  return columnsOf(std::vector<int>(static_cast<size_t>(named), 4));
}

TEST(LightGridFile, ReadsBackWhatWasWritten) {
  for (uint64_t seed = 0; seed < 4; ++seed) {
    LightGrid grid = randomGrid(seed == 0 ? smallTree() : randomTree(seed).tree, seed), read;
    GridMetadata metadata;
    const FileResult result = parseLightGrid(bytesOf(grid), &read, &metadata);
    ASSERT_TRUE(result.ok()) << result.detail;
    expectSameGrid(read, grid);
    EXPECT_EQ(metadata, kMetadata);
  }
}

TEST(LightGridFile, HoldsFunctionsOfProbesByTheirOrderOrByTheirNames) {
  LightGrid grid = randomGrid(smallTree(), 1);
  const std::vector<float> theta(ThetaLayout::count, 0.5f);
  for (const size_t count : {size_t{0x10000}, size_t{0x10001}}) {
    while (grid.functionCount() < count) grid.addFunction(0, theta.data());
    grid.probe_function[5] = static_cast<uint32_t>(count - 1);
    const std::string bytes = bytesOf(grid, {});
    // named are all but the first probes of functions 0, 1, 2, …
    size_t named = 0;
    uint32_t next = 0;
    for (const uint32_t function : grid.probe_function) {
      if (function >= kNoWeight) continue;
      named += function != next;
      next += function == next;
    }
    ASSERT_GT(next, 0u);
    EXPECT_EQ(decoded(bytes, "probe.function", columnsOfNames(bytes)).size(), 4 * named);
    EXPECT_EQ(decoded(bytes, "probe.kind").size(), (grid.tree.probeCount() + 3) / 4);
    LightGrid read;
    ASSERT_TRUE(parse(bytes, &read).ok());
    EXPECT_TRUE(read.probe_function == grid.probe_function);
  }
}

TEST(LightGridFile, RoundsThetaToTheNearestHalf) {
  LightGrid grid = randomGrid(smallTree(), 2), read;
  GridMetadata metadata;
  ASSERT_TRUE(parseLightGrid(bytesOf(grid, {ThetaPrecision::float16}), &read, &metadata).ok());
  for (float& value : grid.theta) {
    Half half;
    ASSERT_TRUE(halfFromFloat(value, &half));
    value = floatFromHalf(half);
  }
  expectSameGrid(read, grid);
}

TEST(LightGridFile, HoldsHiddenLayersInSteps) {
  LightGrid grid = randomGrid(smallTree(), 2), read, again;
  GridMetadata metadata;
  const std::string bytes = bytesOf(grid, {ThetaPrecision::int8});
  ASSERT_TRUE(parseLightGrid(bytes, &read, &metadata).ok());
  for (size_t function = 0; function < grid.functionCount(); ++function) {
    const Representation& representation = grid.representations[grid.function_representation[function]];
    ASSERT_TRUE(roundTheta(representation, ThetaPrecision::int8, &grid.theta[grid.theta_begin[function]]));
  }
  expectSameGrid(read, grid);
  // what was read is written as the same bytes
  EXPECT_EQ(bytesOf(read, {ThetaPrecision::int8}, metadata), bytes);
}

// Functions of codes alone, of these lengths.
LightGrid gridOfCodes(const Representation& code, const std::vector<int>& lengths) {
  LightGrid grid = freeGrid();
  grid.representations = {code};
  Random random(3);
  for (size_t i = 0; i < lengths.size(); ++i)
    grid.probe_function[i] = grid.addFunction(0, sampleCode(*code.dictionary, lengths[i], random).data());
  return grid;
}

TEST(LightGridFile, HoldsOfCodesAndTheirDictionaryWhatIsNeeded) {
  const Representation code = Representation::code(sampleDictionary(9, 64, 4));
  const DictionaryData& whole = code.dictionary->data();
  const std::vector<int> lengths = {8, 0, 24, 16, 40};
  const LightGrid grid = gridOfCodes(code, lengths);
  const std::string bytes = bytesOf(grid, {ThetaPrecision::int8});
  std::map<std::string, Place> places = placesIn(bytes);
  EXPECT_EQ(decoded(bytes, "theta.steps", columnsOf(lengths)).size(), 88u);
  EXPECT_EQ(decoded(bytes, "theta.groups"), (std::vector<uint8_t>{1, 0, 3, 2, 5}));
  EXPECT_EQ(places["dictionary.0.nodes"].count, 41 * 729u);
  EXPECT_EQ(places["dictionary.0.exponents"].count, 41u);
  LightGrid read;
  ASSERT_TRUE(parse(bytes, &read).ok());
  EXPECT_EQ(read.theta, grid.theta);
  EXPECT_EQ(read.quads, grid.quads);
  EXPECT_STREQ(representationName(read.representations[0]), "code64");
  const DictionaryData& kept = read.representations[0].dictionary->data();
  EXPECT_EQ(kept.code_count, 64);
  EXPECT_TRUE(std::equal(kept.nodes.begin(), kept.nodes.begin() + 40 * 729, whole.nodes.begin()));
  EXPECT_TRUE(std::all_of(kept.nodes.begin() + 40 * 729, kept.nodes.end() - 729, [](int8_t node) { return node == 0; }));
  EXPECT_TRUE(std::equal(kept.nodes.end() - 729, kept.nodes.end(), whole.nodes.end() - 729));
  EXPECT_EQ(bytesOf(read, {ThetaPrecision::int8}), bytes);
}

TEST(LightGridFile, HoldsTheLightOfProbesWithWeight) {
  const LightGrid grid = litGrid(smallTree(), 3);
  for (const GridPrecision& precision : kPrecisions) {
    LightGrid read;
    ASSERT_TRUE(parse(bytesOf(grid, precision), &read).ok());
    if (!precision.light_error) {
      EXPECT_TRUE(read.light.empty());
      continue;
    }
    LightGrid rounded = grid;
    EXPECT_LE(roundGridLight(*precision.light_error, &rounded).error, *precision.light_error);
    EXPECT_EQ(read.light, rounded.light);
    size_t dark = 0;
    for (size_t probe = 0; probe < grid.tree.probeCount(); ++probe) {
      if (grid.probe_function[probe] != kNoWeight) continue;
      ++dark;
      for (int i = 0; i < kShFloats; ++i) ASSERT_EQ(read.probeLight(probe)[i], 0.0f) << "probe " << probe;
    }
    EXPECT_GT(dark, 0u);
  }
}

// Light that was packed is written as it is; light that was changed since is packed anew.
TEST(LightGridFile, WritesThePackedLightThatTheGridHolds) {
  LightGrid grid = litGrid(smallTree(), 3);
  roundGridLight(0.3, &grid);
  ASSERT_TRUE(holdsPackedLight(grid));
  LightGrid read;
  ASSERT_TRUE(parse(bytesOf(grid, {ThetaPrecision::float32, 0.005}), &read).ok());
  EXPECT_EQ(read.light, grid.light);
  EXPECT_TRUE(holdsPackedLight(read));
  const size_t probe = static_cast<size_t>(
      std::find_if(grid.probe_function.begin(), grid.probe_function.end(), [](uint32_t f) { return f != kNoWeight; }) -
      grid.probe_function.begin());
  for (int i = 0; i < kShFloats; ++i) grid.light[probe * kShFloats + static_cast<size_t>(i)] *= 100.0f;
  EXPECT_FALSE(holdsPackedLight(grid));
  ASSERT_TRUE(parse(bytesOf(grid, {ThetaPrecision::float32, 0.005}), &read).ok());
  EXPECT_NEAR(read.probeLight(probe)[0], grid.probeLight(probe)[0], 0.05f * std::abs(grid.probeLight(probe)[0]));
}

TEST(LightGridFile, RefusesToWriteAThetaThatHalfCannotHold) {
  LightGrid grid = randomGrid(smallTree(), 2);
  grid.theta[grid.theta_begin[3] + 5] = -65505.0f;
  std::string bytes = "before";
  const FileResult result = serializeLightGrid(grid, {ThetaPrecision::float16}, {}, &bytes);
  EXPECT_EQ(result.status, FileStatus::value_out_of_range);
  EXPECT_EQ(result.detail.substr(0, 27), "function 3: theta 5 is -655") << result.detail;
  EXPECT_TRUE(bytes.empty());
  EXPECT_TRUE(serializeLightGrid(grid, {ThetaPrecision::float32}, {}, &bytes).ok());
}

TEST(LightGridFile, IsTheSameBytesForTheSameGrid) {
  for (const GridPrecision& precision : kPrecisions) {
    const std::string bytes = bytesOf(litGrid(smallTree(), 5), precision);
    EXPECT_TRUE(bytes == bytesOf(litGrid(smallTree(), 5), precision)) << thetaPrecisionName(precision.theta);
    // … and of the grid that was read from them
    LightGrid read;
    ASSERT_TRUE(parse(bytes, &read).ok());
    EXPECT_TRUE(bytes == bytesOf(read, precision)) << thetaPrecisionName(precision.theta);
  }
}

TEST(LightGridFile, AccountsForItsBytes) {
  const LightGrid grid = litGrid(smallTree(), 5);
  for (const GridPrecision& precision : kPrecisions) {
    const LightGridBytes counted = lightGridBytes(grid, precision);
    std::map<std::string, Place> places = placesIn(bytesOf(grid, precision));
    EXPECT_EQ(counted.theta,
              places["theta"].count + places["theta.steps"].count + places["theta.halves"].count + places["theta.groups"].count);
    size_t dictionaries = 0;
    for (const auto& [name, place] : places) dictionaries += name.substr(0, 11) == "dictionary." ? place.count : 0;
    EXPECT_EQ(counted.dictionaries, dictionaries);
    EXPECT_GT(dictionaries, 0u);
    EXPECT_EQ(counted.light, places["light.unit"].count + places["light.bits"].count + places["light.offsets"].count +
                                 places["light.axes"].count + places["light.records"].count);
    EXPECT_EQ(counted.functions, places["function.representation"].count);
    EXPECT_EQ(counted.probe_function, places["probe.function"].count + places["probe.kind"].count + places["probe.count"].count);
    size_t all = 0;
    for (const auto& [name, place] : places) all += name.substr(0, 8) == "padding." ? 0 : place.count;
    EXPECT_EQ(counted.total(), all);
  }
}

TEST(LightGridFile, RefusesWhatIsDamaged) {
  LightGrid grid;
  expectDamageIsRefused(
      bytesOf(litGrid(smallTree(), 1), {}), [&](const std::string& bytes) { return parse(bytes, &grid).detail; }, 13);
}

TEST(LightGridFile, RefusesAFileWithoutADigest) {
  LightGrid read;
  EXPECT_EQ(parse(withoutDigest(bytesOf(litGrid(smallTree(), 1))), &read).status, FileStatus::digest_mismatch);
}

}  // namespace
}  // namespace nlg
