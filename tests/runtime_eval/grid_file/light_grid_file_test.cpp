
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
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

template <class T>
void put(std::string& bytes, const std::string& tensor, size_t index, T value) {
  const Place place = placesIn(bytes).at(tensor);
  ASSERT_LE((index + 1) * sizeof(T), place.count) << tensor;
  std::memcpy(bytes.data() + place.begin + index * sizeof(T), &value, sizeof value);
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

TEST(LightGridFile, TakesLittleBesideThetaAndLight) {
  // a level's tree: cells of one size in a few roots, some left out
  ProbeTree tree;
  const CellJudge judge = [](const ProbeCell& cell) {
    if (cell.side > 4) return CellVerdict::too_coarse;
    return (cell.low[0] ^ cell.low[1] ^ cell.low[2]) & 16 ? CellVerdict::unneeded : CellVerdict::fits;
  };
  ASSERT_EQ(ProbeTree::build({{}, 0.25, {3, 3, 1}}, judge, kMaxTreeProbes, &tree), ProbeTreeStatus::ok);
  const LightGrid grid = litGrid(std::move(tree), 1);
  const LightGridBytes bytes = lightGridBytes(grid, {});
  const size_t probes = grid.tree.probeCount();
  // which function a probe has: a quarter of a byte, and a name of those that are drawn at random here
  EXPECT_LE(bytes.tree + bytes.probe_function, 1.5 * static_cast<double>(probes));
  EXPECT_LE(bytes.light, 32 * probes + 27 * 59 + 5);
}

TEST(LightGridFile, ReadsBackAnEmptyGrid) {
  LightGrid read;
  GridMetadata metadata;
  const FileResult result = parseLightGrid(bytesOf(LightGrid{}, {ThetaPrecision::float16}, {}), &read, &metadata);
  ASSERT_TRUE(result.ok()) << result.detail;
  expectSameGrid(read, {});
  EXPECT_TRUE(metadata.empty());
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

TEST(LightGridFile, HoldsCodesBeyondAByteInCoarserSteps) {
  const Representation code = Representation::code(sampleDictionary(5, 16, 4));
  LightGrid grid = gridOfCodes(code, {16, 8});
  for (float& z : grid.theta) z *= 5.0f;
  grid.makeBricks();
  const std::string bytes = bytesOf(grid, {ThetaPrecision::int8});
  LightGrid read;
  ASSERT_TRUE(parse(bytes, &read).ok());
  for (size_t f = 0; f < 2; ++f) ASSERT_TRUE(roundTheta(code, ThetaPrecision::int8, &grid.theta[grid.theta_begin[f]]));
  grid.makeBricks();
  EXPECT_EQ(read.theta, grid.theta);
  EXPECT_EQ(read.quads, grid.quads);
  EXPECT_GT(decoded(bytes, "theta.groups").front(), kCodeExponentUnit);
  EXPECT_EQ(bytesOf(read, {ThetaPrecision::int8}), bytes);
}

TEST(LightGridFile, HoldsAllNumbersOfACodeInFloats) {
  for (const ThetaPrecision precision : {ThetaPrecision::float32, ThetaPrecision::float16}) {
    const LightGrid grid = gridOfCodes(Representation::code(sampleDictionary(5, 32, 4)), {32, 8});
    const std::string bytes = bytesOf(grid, {precision});
    EXPECT_EQ(placesIn(bytes)["theta"].count, 64 * (precision == ThetaPrecision::float32 ? 4u : 2u));
    LightGrid read;
    ASSERT_TRUE(parse(bytes, &read).ok());
    EXPECT_EQ(read.quads, grid.quads);
    EXPECT_EQ(bytesOf(read, {precision}), bytes);
  }
}

TEST(LightGridFile, HoldsADictionaryThatNoFunctionUses) {
  const LightGrid grid = gridOfCodes(Representation::code(sampleDictionary(3, 16, 4)), {});
  for (const ThetaPrecision precision : {ThetaPrecision::float32, ThetaPrecision::int8}) {
    const std::string bytes = bytesOf(grid, {precision});
    EXPECT_EQ(placesIn(bytes)["dictionary.0.nodes"].count, 27u);
    LightGrid read;
    ASSERT_TRUE(parse(bytes, &read).ok());
    EXPECT_EQ(bytesOf(read, {precision}), bytes);
  }
}

TEST(LightGridFile, RefusesCodesAndDictionariesThatNoFileHas) {
  const LightGrid grid = gridOfCodes(Representation::code(sampleDictionary(5, 16, 4)), {16, 8});
  const std::string bytes = bytesOf(grid, {ThetaPrecision::int8}), floats = bytesOf(grid, {ThetaPrecision::float32});
  const auto renamed = [](std::string other, const std::string& from, const std::string& to) {
    return other.replace(other.find(from), from.size(), to);
  };
  std::string exponent = bytes, zeros = floats;
  put(exponent, "dictionary.0.exponents", 3, int8_t{99});
  for (size_t i = 8; i < 16; ++i) put(zeros, "theta", i, 0.0f);
  const std::tuple<std::string, FileStatus, const char*> cases[] = {
      {exponent, FileStatus::value_out_of_range, "dictionary.0: exponents"},
      {zeros, FileStatus::tensor_unexpected, "dictionary.0.exponents: expected 9 values, got 17"},
      {renamed(bytes, "dictionary.0.nodes", "dictionary.0.knots"), FileStatus::tensor_missing, ""},
      {renamed(bytes, "theta.groups", "theta.graups"), FileStatus::tensor_unexpected, "theta.groups: expected 2 values, got 0"},
      {renamed(bytes, "code16", "code17"), FileStatus::value_out_of_range, "metadata representation.0"},
      {renamed(floats, "code16", "code32"), FileStatus::tensor_unexpected, "theta has 32 entries"}};
  for (const auto& [spoilt, status, detail] : cases) {
    LightGrid read;
    const FileResult result = parse(stamped(spoilt), &read);
    EXPECT_EQ(result.status, status) << result.detail;
    EXPECT_EQ(result.detail.substr(0, std::strlen(detail)), detail);
  }
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

TEST(LightGridFile, RefusesToWriteLightThatNoReaderTakes) {
  LightGrid grid = litGrid(smallTree(), 3);
  std::fill(grid.probe_function.begin(), grid.probe_function.end(), kFreeSpace);
  std::string bytes;
  grid.light[0] = 0.9f * kMaxGridLight;
  EXPECT_TRUE(serializeLightGrid(grid, {ThetaPrecision::float32, 0.005}, {}, &bytes).ok());
  grid.light[1] = 1.01f * kMaxGridLight;
  EXPECT_EQ(serializeLightGrid(grid, {ThetaPrecision::float32, 0.005}, {}, &bytes).status, FileStatus::value_out_of_range);
  EXPECT_TRUE(bytes.empty());
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

TEST(LightGridFile, RefusesToWriteWhatItWouldNotRead) {
  LightGrid grid = randomGrid(smallTree(), 2);
  std::string bytes;
  for (const char* key :
       {"file_sha256", "kind", "version", "pattern_hash", "representation_count", "representation.0", "slope.7"}) {
    EXPECT_EQ(serializeLightGrid(grid, {ThetaPrecision::float32}, {{key, ""}}, &bytes).status, FileStatus::value_out_of_range)
        << key;
  }
  EXPECT_EQ(serializeLightGrid(grid, {ThetaPrecision::float32}, {{"scene", "\xc0"}}, &bytes).status,
            FileStatus::header_malformed);
  grid.probe_function[0] = 1000;
  EXPECT_EQ(serializeLightGrid(grid, {ThetaPrecision::float32}, {}, &bytes).status, FileStatus::value_out_of_range);
  EXPECT_TRUE(bytes.empty());
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

TEST(LightGridFile, AlignsEveryTensor) {
  for (const GridPrecision& precision : kPrecisions) {
    const std::string bytes = bytesOf(litGrid(smallTree(), 5), precision);
    uint64_t length = 0;
    std::memcpy(&length, bytes.data(), sizeof length);
    const nlohmann::json header = nlohmann::json::parse(bytes.substr(8, length));
    int fillers = 0;
    for (const auto& [name, place] : placesIn(bytes)) {
      EXPECT_EQ(place.begin % dtypeBytes(header[name]["dtype"].get<std::string>()), 0u) << name;
      fillers += isPadding(name);
    }
    EXPECT_LE(fillers, 2);
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

TEST(LightGridFile, IsReadFromAFile) {
  const std::string path = testing::TempDir() + "light_grid_" + std::to_string(getpid()) + ".safetensors";
  const LightGrid grid = randomGrid(smallTree(), 6);
  const std::string bytes = bytesOf(grid);
  std::ofstream(path, std::ios::binary) << bytes;
  LightGrid read;
  GridMetadata metadata;
  FileResult result = readLightGridFile(path, &read, &metadata);
  ASSERT_TRUE(result.ok()) << result.detail;
  expectSameGrid(read, grid);
  std::filesystem::resize_file(path, bytes.size() - 1);
  result = readLightGridFile(path, &read, &metadata);
  EXPECT_EQ(result.status, FileStatus::too_short);
  EXPECT_EQ(result.detail.substr(0, path.size()), path);
  std::filesystem::remove(path);
  EXPECT_EQ(readLightGridFile(path, &read, &metadata).status, FileStatus::cannot_open);
}

TEST(LightGridFile, RefusesWhatIsDamaged) {
  LightGrid grid;
  expectDamageIsRefused(bytesOf(litGrid(smallTree(), 1), {}),
                        [&](const std::string& bytes) { return parse(bytes, &grid).detail; });
}

TEST(LightGridFile, RefusesAFileWithoutADigest) {
  LightGrid read;
  EXPECT_EQ(parse(withoutDigest(bytesOf(litGrid(smallTree(), 1))), &read).status, FileStatus::digest_mismatch);
}

// One number changed, and what the reader says.
struct Hostile {
  const char* what;
  FileStatus status;
  const char* detail;  // its beginning
  std::function<void(std::string&)> spoil;
};

// Of numbers that stand as they are; of coded ones the fuzz target makes what there is.
TEST(LightGridFile, NamesHostileNumbers) {
  constexpr FileStatus kRange = FileStatus::value_out_of_range;
  const double infinity = std::numeric_limits<double>::infinity();
  const Hostile cases[] = {
      {"far origin", kRange, "probe tree: frame", [=](std::string& b) { put(b, "frame.first_m", 1, infinity); }},
      {"spacing 0", kRange, "probe tree: frame", [=](std::string& b) { put(b, "frame.spacing_m", 0, 0.0); }},
      {"many roots", kRange, "probe tree: frame", [=](std::string& b) { put(b, "frame.root_count", 0, int32_t{1} << 30); }},
      {"more roots than nodes", kRange, "probe tree: frame",
       [=](std::string& b) {
         for (size_t axis = 0; axis < 3; ++axis) put(b, "frame.root_count", axis, int32_t{32767});
       }},
      {"no roots", kRange, "probe tree: nodes", [=](std::string& b) { put(b, "frame.root_count", 0, int32_t{0}); }},
      {"more probes than there are kinds", FileStatus::tensor_unexpected, "probe.kind",
       [=](std::string& b) { put(b, "probe.count", 0, uint32_t{1u << 12}); }},
      {"more probes than the file stands for", kRange, "memory: expected",
       [=](std::string& b) { put(b, "probe.count", 0, uint32_t{1u << 20}); }},
      {"theta NaN", FileStatus::value_not_finite, "theta: value 9", [=](std::string& b) { put(b, "theta", 9, std::nanf("")); }},
      {"an axis NaN", FileStatus::value_not_finite, "light.axes: value 9",
       [=](std::string& b) { put(b, "light.axes", 9, uint16_t{0x7e00}); }},
      {"no unit", kRange, "light.unit", [=](std::string& b) { put(b, "light.unit", 0, 0.0f); }},
      {"a unit NaN", kRange, "light.unit", [=](std::string& b) { put(b, "light.unit", 0, std::nanf("")); }},
      {"light beyond what look-ups take", kRange, "light: value", [=](std::string& b) { put(b, "light.unit", 0, 1e30f); }},
      {"a scale of 12 bits", kRange, "light.bits: value 0", [=](std::string& b) { put(b, "light.bits", 0, uint8_t{12}); }},
      {"an axis far off", kRange, "light.offsets: value 1", [=](std::string& b) { put(b, "light.offsets", 1, int32_t{4097}); }},
  };
  const std::string bytes = bytesOf(litGrid(smallTree(), 1), {ThetaPrecision::float32});
  for (const Hostile& hostile : cases) {
    std::string spoilt = bytes;
    hostile.spoil(spoilt);
    LightGrid grid;
    const FileResult result = parse(stamped(spoilt), &grid);
    EXPECT_EQ(result.status, hostile.status) << hostile.what << ": " << result.detail;
    EXPECT_EQ(result.detail.substr(0, std::strlen(hostile.detail)), hostile.detail) << hostile.what;
  }
}

TEST(LightGridFile, RefusesOtherTextsOfItsOwn) {
  struct Edit {
    const char *from, *to;  // of one length, so that the file stays whole
    FileStatus status;
  };
  const Edit edits[] = {
      {R"("kind":"nlg-light-grid")", R"("kind":"nlg-light-grod")", FileStatus::value_out_of_range},
      {R"("version":"2")", R"("version":"3")", FileStatus::version_unknown},
      {R"("light":"axes")", R"("light":"axle")", FileStatus::value_out_of_range},
      {R"("light.bits":{)", R"("light.bats":{)", FileStatus::tensor_missing},
      {R"("pattern_hash":")", R"("pattern_hash":"\)", FileStatus::header_malformed},
      {R"("representation_count":"8")", R"("representation_count":"9")", FileStatus::tensor_missing},
      {R"("representation_count":"8")", R"("representation_count":"7")", FileStatus::value_out_of_range},
      {R"("representation.2":"pf3")", R"("representation.2":"pf4")", FileStatus::value_out_of_range},
      {R"("slope.1":"0.3")", R"("slope.1":"0.x")", FileStatus::value_out_of_range},
      {R"("node.kind":{"dtype":"U8")", R"("node.kind":{"dtype":"V8")", FileStatus::tensor_malformed},
      {R"("node.kind":{"dtype":"U8")", R"("node.kind":{"dtype":"I8")", FileStatus::tensor_unexpected},
      {R"("frame.spacing_m":{"dtype":"F64","shape":[1])", R"("frame.spacing_m":{"dtype":"F32","shape":[2])",
       FileStatus::tensor_unexpected},
  };
  const std::string bytes = bytesOf(litGrid(smallTree(), 1));
  for (const Edit& edit : edits) {
    std::string edited = bytes;
    const size_t place = edited.find(edit.from);
    ASSERT_NE(place, std::string::npos) << edit.from;
    edited.replace(place, std::strlen(edit.from), edit.to);
    LightGrid grid;
    const FileResult result = parse(stamped(edited), &grid);
    EXPECT_EQ(result.status, edit.status) << edit.to << ": " << result.detail;
  }
  std::string other_pattern = bytes;
  char& digit = other_pattern[other_pattern.find(R"("pattern_hash":")") + 16];
  digit = digit == '0' ? '1' : '0';
  LightGrid grid;
  EXPECT_EQ(parse(stamped(other_pattern), &grid).status, FileStatus::pattern_unknown);
}

}  // namespace
}  // namespace nlg
