// Hostile shards: whatever the file, it is refused in one line, or its functions can be read, all at once and one by one.
#include "datagen/dataset/shard.h"
#include "datagen/dataset/shard_check.h"
#include "datagen/dataset/shard_file.h"
#include "tests/fuzz/hdf5_recipe.h"

// HDF5 1.10.8 itself loses some hundred bytes for each damaged file that it refuses.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace nlg::fuzz {
namespace {

constexpr uint64_t kFunctions = 3;
constexpr int kPoints = 16, kTestPoints = 8;

std::vector<Hdf5Item> rightShard() {
  FunctionRows rows;
  rows.point_count = kPoints;
  rows.test_point_count = kTestPoints;
  ShardCounts counts{10, 9, kFunctions, 1, 2, 3, 0, 1};
  std::vector<Hdf5Item> items = {textItem("kind", kShardKind),
                                 attributeItem("schema_version", uint64_t{kShardVersion}),
                                 textItem("scene_id", "rooms/1"),
                                 textItem("family", "rooms"),
                                 attributeItem("jitter", uint64_t{1}),
                                 attributeItem("pattern_hash", uint64_t{7}),
                                 attributeItem("test_pattern_hash", uint64_t{8}),
                                 attributeItem("point_count", uint64_t{kPoints}),
                                 attributeItem("test_point_count", uint64_t{kTestPoints}),
                                 textItem("provenance_json", "{}"),
                                 attributeItem("duplicate_rms", 0.5),
                                 attributeItem("duplicate_validity_points", uint64_t{4})};
  forEachCount([&](const char* name, uint64_t value) { items.push_back(attributeItem(name, value)); }, counts);
  forEachArray(
      [&](const char* name, const std::vector<uint64_t>& columns, auto& values) {
        // all points valid, all values 1
        values.assign(kFunctions * rowWidth(columns), typename std::remove_reference_t<decltype(values)>::value_type{1});
        std::vector<uint64_t> shape = columns;
        shape.insert(shape.begin(), kFunctions);
        if (std::string_view(name).starts_with("validity"))
          values.assign(values.size(), typename std::remove_reference_t<decltype(values)>::value_type(255));
        items.push_back(arrayItem(name, shape, values));
      },
      rows);
  return items;
}

void readAll(const std::string& path) {
  const ShardReader reader(path);
  const uint64_t count = reader.functionCount();
  const Shard whole = reader.read(0, count);
  FUZZ_CHECK(whole.functionCount() == count, std::to_string(count));
  FUZZ_CHECK(whole.phi.size() == count * static_cast<uint64_t>(whole.point_count), std::to_string(whole.phi.size()));
  // files are read twice here: what was right as a whole is right by parts
  for (uint64_t i = 0; i < std::min<uint64_t>(count, 4); ++i) {
    const Shard one = reader.read(i, 1);
    FUZZ_CHECK(std::equal(one.phi.begin(), one.phi.end(), whole.phi.begin() + static_cast<ptrdiff_t>(i * one.phi.size())), "phi");
  }
  reader.verifyDigest();
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("shard.h5");
  static const std::vector<Hdf5Item> right = rightShard();
  writeRecipe(right, bytes, file);
  isTaken([] { readAll(file.path()); });
}

Seeds seeds() {
  Seeds seeds = recipeSeeds();
  const ScratchFile file("seed");
  writeRecipe(rightShard(), "", file);
  // a seed that is refused would be none
  readAll(file.path());
  seeds.emplace_back("file", file.read());
  return seeds;
}

std::string mutated(std::string bytes, size_t max_size, Random&) { return mutatedBlindly(std::move(bytes), max_size); }

}  // namespace nlg::fuzz
