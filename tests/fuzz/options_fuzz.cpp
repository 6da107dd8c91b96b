// Hostile pipeline.yaml: whatever the text, it is refused in one line, or every option is within its range.
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/fuzz/fuzz.h"
#include "tool/command/options.h"

namespace nlg::fuzz {

void readOne(std::string_view bytes) {
  static const ScratchFile file("pipeline.yaml");
  file.write(bytes);
  int count = 3;
  uint64_t seed = 1;
  double spacing_m = 0.5;
  bool is_culled = true;
  std::string folder = "levels";
  std::vector<std::string> names = {"mlp"};
  OptionTable table("datagen");
  table.add("count", &count, "how many", 1, 100);
  table.add("seed", &seed, "of random numbers");
  table.add("spacing_m", &spacing_m, "between probes, metres", 0.01, 100.0);
  table.add("culling", &is_culled, "whether to");
  table.add("folder", &folder, "of levels");
  table.add("names", &names, "of representations");
  if (!isTaken([&] { table.readYaml(file.path()); })) return;
  FUZZ_CHECK(count >= 1 && count <= 100, std::to_string(count));
  FUZZ_CHECK(spacing_m >= 0.01 && spacing_m <= 100.0, std::to_string(spacing_m));
  FUZZ_CHECK(folder.find('\0') == folder.npos, "a text that the system would cut");
  for (const std::string& name : names) FUZZ_CHECK(!name.empty() && name.find('\0') == name.npos, name);
  FUZZ_CHECK(table.toJson().size() == 6, "all options");
}

Seeds seeds() {
  return {
      {"all", R"(# of a run
name: test
scenes: {folder: levels, held_out: [a, b]}
datagen:
  count: 7
  seed: 18446744073709551615
  spacing_m: 1.5e-1
  culling: false
  folder: "over \"there\"\t\x41\u00e9"
  names: [mlp, 'tent_mlp', pf3]
effort: full
)"},
      {"anchors", "datagen: &d\n  count: 3\n  names:\n  - &n a\n  - *n\ntrain: *d\n"},
      {"wrong", "datagen: {number: 3, cuont: 4, culling: !!binary AA==, folder: ~, names: []}\n"},
      {"blocks", "--- # first\ndatagen:\n  folder: |\n    one\n    two\n  names: [>-\n   x ]\n...\n---\nsecond: {? a : b}\n"}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
