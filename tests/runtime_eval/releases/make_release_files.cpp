// Writes what readers of later versions are held to: make_release_files tests/runtime_eval/releases/VERSION. Run once, at a release.
//   grid.safetensors      functions of every representation, light in two groups, one of which begins dark
//   look_ups.txt          lines x y z  nx ny nz  r g b: irradiance with both groups lit
//   NAME.safetensors      small generators of random numbers: of a network, which reads coefficients, and of a code, which reads samples
//   NAME.txt              lines of theta, a line a function of functions.bin
#include <fstream>
#include <iostream>
#include <tuple>

#include "nlg/look_up.h"
#include "tests/runtime_eval/light_grid/random_grid.h"
#include "tests/runtime_eval/releases/release_files.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {
namespace {

constexpr int kFunctions = 3, kLookUps = 200;

std::ofstream opened(const std::string& path) {
  std::ofstream stream(path, std::ios::binary);
  stream.precision(9);
  return stream;
}

bool writeGrid(const std::string& folder) {
  LightGrid grid = litGrid(smallTree(), 1);
  const std::vector<float> lamps = randomLight(grid.tree.probeCount(), 2);
  grid.groups = {{"sky", grid.light, false}, {"lamps", lamps, true}};
  std::string bytes;
  if (!serializeLightGrid(grid, {ThetaPrecision::int8, kLightError}, {}, &bytes).ok()) return false;
  opened(folder + "/grid.safetensors") << bytes;
  GridMetadata metadata;
  if (!parseLightGrid(bytes, &grid, &metadata).ok() || !mixLight(kBothLit, &grid).ok()) return false;
  std::ofstream answers = opened(folder + "/look_ups.txt");
  Random random(3);
  for (int found = 0; found < kLookUps;) {
    const PositionM at = {-3.0 + random.uniform(0.0, 32.0), 1e4 + random.uniform(0.0, 32.0), 0.25 + random.uniform(0.0, 32.0)};
    const float normal[3] = {static_cast<float>(random.uniform(-1.0, 1.0)), static_cast<float>(random.uniform(-1.0, 1.0)), 0.5f};
    float rgb[3];
    if (lookUpIrradiance(grid, at, normal, rgb) != LightStatus::lit) continue;
    ++found;
    answers.precision(17);
    answers << at[0] << ' ' << at[1] << ' ' << at[2];
    answers.precision(9);
    answers << ' ' << normal[0] << ' ' << normal[1] << ' ' << normal[2] << ' ' << rgb[0] << ' ' << rgb[1] << ' ' << rgb[2]
            << '\n';
  }
  return answers.flush().good();
}

bool writeGenerators(const std::string& folder) {
  const std::vector<uint8_t> functions = sampleFunctions(kFunctions).phi;
  opened(folder + "/functions.bin").write(reinterpret_cast<const char*>(functions.data()), functions.size());
  using Made = std::tuple<std::string, Representation, GeneratorInput>;
  for (const auto& [name, representation, input] :
       {Made("tent_mlp", Representation::tentMlp(0.01f), GeneratorInput::coefficients),
        Made("code16", Representation::code(sampleDictionary(5, 16, 1)), GeneratorInput::samples)}) {
    opened(folder + "/" + name + ".safetensors")
        << serializeWeights(weightsFromGenerator(sampleGenerator(representation, 24, 3, 1, input)));
    std::ofstream answers = opened(folder + "/" + name + ".txt");
    for (const std::vector<float>& theta : thetasOf(folder + "/" + name + ".safetensors", functions)) {
      for (const float value : theta) answers << value << ' ';
      answers << '\n';
    }
    if (!answers.flush()) return false;
  }
  return true;
}

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc == 2 && nlg::writeGrid(argv[1]) && nlg::writeGenerators(argv[1])) return 0;
  std::cerr << "make_release_files: expected a folder that can be written\n";
  return 1;
}
