// Dictionaries of smooth logits drawn at random, and codes of them, to test with.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {

// Waves of few periods, whose sum over a sampleCode's numbers has a deviation of one logit (8 numbers) to six (128).
inline DictionaryData sampleDictionaryData(int resolution, int code_count, uint64_t seed) {
  Random random(seed);
  const int nodes = resolution * resolution * resolution;
  DictionaryData data;
  data.resolution = resolution;
  data.code_count = code_count;
  const auto addRow = [&](double largest, int exponent) {
    double rate[3], phase[3];
    for (int axis = 0; axis < 3; ++axis) {
      rate[axis] = random.uniform(0.0, 1.5 * std::numbers::pi);
      phase[axis] = random.uniform(0.0, 2.0 * std::numbers::pi);
    }
    for (int n = 0; n < nodes; ++n) {
      const int node[3] = {n % resolution, n / resolution % resolution, n / (resolution * resolution)};
      double value = largest;
      for (int axis = 0; axis < 3; ++axis)
        value *= std::cos(rate[axis] * (2.0 * node[axis] / (resolution - 1) - 1.0) + phase[axis]);
      data.nodes.push_back(static_cast<int8_t>(std::lround(value)));
    }
    data.exponents.push_back(static_cast<int8_t>(exponent));
  };
  for (int k = 0; k < code_count; ++k) {
    // rows of two exponents, the larger first, as a dictionary that is ordered has them
    addRow(127.0, k < code_count / 2 ? -11 : -12);
    data.deviations.push_back(static_cast<float>(random.uniform(20.0, 40.0)));
  }
  addRow(127.0, -6);
  return data;
}

inline SharedDictionary sampleDictionary(int resolution, int code_count, uint64_t seed) {
  DictionaryData data = sampleDictionaryData(resolution, code_count, seed);
  if (const std::string fault = whatIsWrong(data); !fault.empty()) throw std::logic_error(fault);
  return std::make_shared<const Dictionary>(std::move(data));
}

// Every representation that has a name; codes of a dictionary of 9³ nodes.
inline std::vector<Representation> sampleRepresentations() {
  std::vector<Representation> all;
  for (const char* name : kRepresentationNames) {
    Representation& one = all.emplace_back();
    if (!findRepresentation(name, &one)) throw std::logic_error(name);
    if (one.isCode()) one = Representation::code(sampleDictionary(9, one.code_count, 1));
  }
  return all;
}

// The numbers of a stored code: whole, of which those from `length` on are 0, and the last before it is not.
inline Theta sampleCode(const Dictionary& dictionary, int length, Random& random) {
  Theta z(static_cast<size_t>(dictionary.codeCount()), 0.0f);
  for (int k = 0; k < length; ++k) {
    const auto value = static_cast<float>(dictionary.deviations()[k] * random.normal());
    z[static_cast<size_t>(k)] =
        std::clamp(std::nearbyint(value), -static_cast<float>(kMostCodeSteps), static_cast<float>(kMostCodeSteps));
  }
  if (length > 0 && z[static_cast<size_t>(length - 1)] == 0.0f) z[static_cast<size_t>(length - 1)] = 1.0f;
  return z;
}

}  // namespace nlg
