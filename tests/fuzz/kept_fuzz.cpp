// Hostile files of what a bake kept: whatever the bytes, the reader says what is wrong, or gives what can be written again and read as
// the same.
#include <nlohmann/json.hpp>

#include "bake/again/kept_functions_file.h"
#include "tests/fuzz/digests.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {
namespace {

const nlohmann::ordered_json& origin() {
  static const nlohmann::ordered_json made = {{"revision", "a"}};
  return made;
}

Representation tinyNetwork() { return {RepresentationKind::tent_mlp4}; }

KeptProbe probeOf(uint64_t number, const std::shared_ptr<KeptFunction>& function) {
  KeptProbe probe;
  probe.key = {number, ~number};
  probe.outcome = ProbeOutcome::function;
  probe.eye = {0.25f, -1.0f, static_cast<float>(number) / 8.0f};
  FarQuestion asked;
  asked.point_count = 2;
  asked.points = {7, 8191};
  asked.solid = number % 2 != 0;
  probe.asked.assign(number, asked);
  probe.function = function;
  if (!function) probe.bare_tent_rmse = 0.001;
  return probe;
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("kept");
  file.write(withRightDigest(std::string(bytes)));
  std::string told;
  const auto read = [&] { return readKept(file.path(), origin(), {tinyNetwork()}, &told); };
  KeptProbes probes;
  if (!isTaken([&] { probes = read(); })) return;
  FUZZ_CHECK(told.empty() || probes.empty(), told);
  for (const KeptProbe& probe : probes) {
    for (const FarQuestion& asked : probe.asked)
      FUZZ_CHECK(asked.point_count <= FarQuestion::kMostPoints, std::to_string(asked.point_count));
  }
  const std::string written = keptBytes(probes, origin());
  file.write(written);
  FUZZ_CHECK(keptBytes(read(), origin()) == written, "the same again");
}

Seeds seeds() {
  const auto function = std::make_shared<KeptFunction>(KeptFunction{{3, 4}, {1, 2, 3}, {}});
  const auto with_theta = std::make_shared<KeptFunction>(*function);
  with_theta->theta.emplace().made.theta.assign(static_cast<size_t>(tinyNetwork().thetaCount()), 0.5f);
  KeptProbe nothing;
  nothing.outcome = ProbeOutcome::in_solid;
  return {{"none", keptBytes({}, origin())},
          {"solid", keptBytes({nothing}, origin())},
          {"tent", keptBytes({probeOf(1, nullptr)}, origin())},
          {"shared", keptBytes({probeOf(0, with_theta), probeOf(2, with_theta), probeOf(3, function)}, origin())}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
