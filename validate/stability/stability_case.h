// One case of the stability suite: a stiff or extreme input, and figures with the bounds that they must keep.
//
// A case measures through the same entry points as the tools. What it promises is what a user of them needs, never what happens to
// come out. docs/reference/results.md lists all cases.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator/generator_data.h"

namespace nlg {

// An exported generator as engines get it, and its numbers for the reference in double.
struct NamedGenerator {
  std::string name;  // of its representation
  Generator generator;
  GeneratorData data;
};

struct StabilityInputs {
  bool is_short = false;  // fewer functions a case, and shorter direct fits
  std::vector<NamedGenerator> generators;
};

// What a case measured. It holds while every figure is within its bound and nothing is said to be broken.
class StabilityFigures {
 public:
  // Key: snake_case, with its unit. A figure of a key that is there replaces it.
  void show(const std::string& key, double value);
  void atMost(const std::string& key, double value, double bound);
  void atLeast(const std::string& key, double value, double bound);
  void equals(const std::string& key, double value, double wanted);
  // What no figure says; `claim` stands in the table where it is broken.
  void require(bool holds, const std::string& claim);
  // One word or name that belongs to the figures: "outcome: free space".
  void remark(const std::string& text);

  // What a bake stores of some function here fails its check, which counts it: allowed where the bound is wider than the check's.
  bool fails_check = false;

  bool holds() const { return holds_; }
  // Figures by key. JSON knows no infinity: null says that a figure was not finite.
  const nlohmann::ordered_json& figures() const { return figures_; }
  // All of it in one line for readers: "rmse stored 0.0123 (at most 0.02); …".
  const std::string& measured() const { return measured_; }

 private:
  void add(const std::string& key, double value, bool holds, const std::string& bound);
  void say(const std::string& text);

  bool holds_ = true;
  int broken_count_ = 0;
  nlohmann::ordered_json figures_ = nlohmann::ordered_json::object();
  std::string measured_;
};

struct StabilityCase {
  std::string group, name;
  std::string must_hold;  // one sentence
  std::function<void(const StabilityInputs&, StabilityFigures*)> measure;
  bool needs_codes = false;  // is left out where no generator is a code's
};

// The cases in the table's order.
std::vector<StabilityCase> sampledFunctionCases();
std::vector<StabilityCase> wallCases();
std::vector<StabilityCase> codeCases();
std::vector<StabilityCase> coefficientCases();

// The command nlg-validate stability: runs every case, and writes one JSON file.
// returns   the exit code: check_failed, after the file is written, when some case did not hold
int stabilityMain(int argc, char** argv);

}  // namespace nlg
