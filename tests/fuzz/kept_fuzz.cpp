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

KeptThetas thetasOf(int count) {
  KeptThetas thetas;
  for (int n = 0; n < count; ++n) {
    KeptTheta& theta = thetas[{static_cast<uint64_t>(n), ~static_cast<uint64_t>(n)}];
    theta.made.record.took_fit = n % 2 != 0;
    theta.made.theta.assign(static_cast<size_t>(tinyNetwork().thetaCount()), 0.5f);
  }
  return thetas;
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("kept");
  file.write(withRightDigest(std::string(bytes)));
  std::string told;
  const auto read = [&] { return readKept(file.path(), origin(), {tinyNetwork()}, &told); };
  KeptThetas thetas;
  if (!isTaken([&] { thetas = read(); })) return;
  FUZZ_CHECK(told.empty() || thetas.empty(), told);
  const std::string written = keptBytes(thetas, origin());
  file.write(written);
  FUZZ_CHECK(keptBytes(read(), origin()) == written, "the same again");
}

Seeds seeds() {
  return {{"none", keptBytes({}, origin())},
          {"one", keptBytes(thetasOf(1), origin())},
          {"several", keptBytes(thetasOf(3), origin())}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
