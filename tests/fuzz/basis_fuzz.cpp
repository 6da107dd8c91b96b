// Hostile basis files: whatever the file, it is refused in one line, or holds a basis whose numbers are finite and as many as its
// counts say.
#include <cmath>

#include "tests/fuzz/hdf5_recipe.h"
#include "tests/runtime_eval/sample_generator.h"
#include "train/basis/basis_file.h"

// HDF5 1.10.8 itself loses some hundred bytes for each damaged file that it refuses.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace nlg::fuzz {
namespace {

std::vector<Hdf5Item> rightBasis() {
  const BasisData data = sampleBasis({1, 1, 0, 0, 0, 0, 0, 1}, 1);
  const auto count = static_cast<uint64_t>(data.coefficientCount());
  const std::vector<int32_t> class_count(data.class_count.begin(), data.class_count.end());
  constexpr uint64_t kClasses = kParityClassCount, kOctant = kOctantPointCount, kPoints = kSupportPointCount;
  return {textItem("kind", "nlg-basis"),
          attributeItem("schema_version", uint64_t{1}),
          attributeItem("pattern_hash", supportPattern().hash),
          attributeItem("function_count", uint64_t{321}),
          textItem("provenance", "{}"),
          arrayItem("class_count", {kClasses}, class_count),
          arrayItem("mean", {kClasses, kOctant}, data.mean),
          arrayItem("components", {count, kOctant}, data.components),
          arrayItem("deviation", {count}, data.deviation),
          arrayItem("spectrum", {kClasses, kOctant}, std::vector<double>(kPoints, 0.5)),
          arrayItem("mean_function", {kPoints}, std::vector<float>(kPoints, 0.5f)),
          arrayItem("mean_validity", {kPoints}, std::vector<float>(kPoints, 0.5f)),
          arrayItem("kept_counts", {2}, std::vector<int32_t>{1, 3}),
          arrayItem("kept_variance", {2}, std::vector<double>{0.5, 0.75})};
}

void readAll(const std::string& path) {
  const BasisFile file = readBasisFile(path);
  const BasisData& data = file.basis.data;
  const auto count = static_cast<size_t>(data.coefficientCount());
  FUZZ_CHECK(count > 0 && data.deviation.size() == count, std::to_string(count));
  FUZZ_CHECK(data.components.size() == count * kOctantPointCount, std::to_string(data.components.size()));
  for (const float value : data.components) FUZZ_CHECK(std::isfinite(value), std::to_string(value));
  for (const float value : data.deviation) FUZZ_CHECK(std::isfinite(value) && value > 0.0f, std::to_string(value));
  FUZZ_CHECK(file.kept_counts.size() == file.kept_variance.size(), std::to_string(file.kept_counts.size()));
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("basis.h5");
  static const std::vector<Hdf5Item> right = rightBasis();
  writeRecipe(right, bytes, file);
  isTaken([] { readAll(file.path()); });
}

Seeds seeds() {
  const ScratchFile file("seed");
  writeRecipe(rightBasis(), "", file);
  // a seed that is refused would be none
  readAll(file.path());
  return recipeSeeds();
}

std::string mutated(std::string bytes, size_t max_size, Random&) { return mutatedBlindly(std::move(bytes), max_size); }

}  // namespace nlg::fuzz
