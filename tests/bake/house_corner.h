// A small bake for tests: a corner of a house, of every kind of probe but those that are 0 everywhere, fitted for next to no time.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

#include "bake/scene_bake.h"
#include "tests/runtime_eval/sample_generator.h"

namespace nlg {

inline BakeOptions houseCornerOptions(int refine_rounds = 0) {
  BakeOptions options;
  options.spacing_m = 1.5;
  options.extent_m = {"0", "0", "0", "4.5", "4.5", "3"};
  options.policy.theta_precision = ThetaPrecision::float32;  // rounding solves last layers again, which hides what stages do
  options.policy.refine_rounds = refine_rounds;
  options.policy.refine_first_steps = 4;
  options.policy.adam_steps = 20;
  options.threads = 2;
  return options;
}

// Small generators of numbers at random.
inline std::vector<Generator> sampleGenerators(const std::vector<std::string>& names = {"tent_mlp4"}) {
  std::vector<Generator> generators;
  for (const std::string& name : names) {
    Representation representation;
    EXPECT_TRUE(findRepresentation(name, &representation)) << name;
    generators.emplace_back(sampleGenerator(representation, 24, 3, 1));
  }
  return generators;
}

inline Bake bakeOf(const PreparedScene& scene, const BakeOptions& options, const GridMetadata& metadata = {},
                   const std::vector<Generator>& generators = sampleGenerators()) {
  return bakeScene(scene, generators, options, std::filesystem::temp_directory_path().string(), metadata);
}

}  // namespace nlg
