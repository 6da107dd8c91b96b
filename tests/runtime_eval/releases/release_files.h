// What the files of a release are asked, by their maker and by the test.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "nlg/generator.h"
#include "nlg/support.h"

namespace nlg {

inline const std::vector<std::array<float, 3>> kBothLit = {{1.0f, 1.0f, 1.0f}, {1.0f, 0.5f, 0.25f}};

// One theta a function; none where the file is refused.
inline std::vector<std::vector<float>> thetasOf(const std::string& path, const std::vector<uint8_t>& functions) {
  Generator generator;
  std::vector<std::vector<float>> thetas;
  if (!Generator::load(path, &generator).ok()) return thetas;
  GeneratorScratch scratch(generator);
  const std::vector<uint8_t> validity(kValidityByteCount, 0xff);
  for (size_t begin = 0; begin < functions.size(); begin += kSupportPointCount) {
    thetas.emplace_back(static_cast<size_t>(generator.representation().thetaCount()));
    const StoredFunction function{&functions[begin], validity.data()};
    generator.generate(&function, 1, thetas.back().data(), &scratch);
  }
  return thetas;
}

}  // namespace nlg
