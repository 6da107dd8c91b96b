// One case of the stability suite: what must hold for a stiff or extreme input, and how that is measured.
//
// A case measures through the same entry points as the tools; what it promises is what a user of them needs, never what happens
// to come out. docs/reference/results.md lists all cases.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "runtime_eval/evaluator/generator.h"

namespace nlg {

// How much of the suite runs: each depth includes the ones before it.
enum class StabilityDepth {
  brief,    // some seconds: the tests
  full,     // about a minute
  lengthy,  // minutes, and gigabytes of memory
};

// An exported generator as engines get it, and its numbers for the reference in double.
struct NamedGenerator {
  std::string name;  // of its representation
  Generator generator;
  GeneratorData data;
};

struct StabilityInputs {
  StabilityDepth depth = StabilityDepth::full;
  std::vector<NamedGenerator> generators;
};

struct StabilityResult {
  bool holds = false;
  // what a bake stores of some function here fails its check, which counts it: allowed where the bound is wider than tau
  bool fails_check = false;
  std::string measured;                   // one short sentence with the figures
  std::map<std::string, double> figures;  // by snake_case name with its unit
  std::string note;                       // what a reader must know to judge it; else empty
};

struct StabilityCase {
  std::string group, name;
  std::string must_hold;  // one sentence
  StabilityDepth depth = StabilityDepth::brief;
  bool needs_generators = false;
  std::function<StabilityResult(const StabilityInputs&)> measure;
};

// The cases in the table's order, by what they are about.
// functions
std::vector<StabilityCase> sampledFunctionCases();
std::vector<StabilityCase> wallCases();
// optimisers
std::vector<StabilityCase> singularJacobianCases();
std::vector<StabilityCase> extremeFitCases();
std::vector<StabilityCase> hopelessStartCases();
std::vector<StabilityCase> singularMatrixCases();
// pca
std::vector<StabilityCase> pcaCases();
// generator
std::vector<StabilityCase> generatorPrecisionCases();
std::vector<StabilityCase> heldOutFamilyCases();
// scenes
std::vector<StabilityCase> sceneSizeCases();
std::vector<StabilityCase> strangeTriangleCases();
std::vector<StabilityCase> triangleCountCases();

}  // namespace nlg
