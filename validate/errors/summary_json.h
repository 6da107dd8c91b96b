// The pieces of summary.json, schema version 2: docs/reference/formats.md says what stands in them.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "validate/errors/best_known.h"
#include "validate/errors/convergence.h"
#include "validate/errors/figures.h"
#include "validate/errors/policy_words.h"

namespace nlg {

// Everything that was measured of one generator.
struct ValidatedGenerator {
  const Generator& generator;
  std::string path;  // where it was read from
  PolicyWords policy;
  LongFits fits;
  Convergence convergence;
};

nlohmann::ordered_json tauJson(const ValidateOptions& options);
nlohmann::ordered_json functionsJson(const ShardCounts& counts, const FigureContext& context);
nlohmann::ordered_json bootstrapJson(const FigureContext& context);
// A stage a line: name, word, population, above_rmse, budget, and the sentence that --help prints.
nlohmann::ordered_json stagesJson(const std::vector<StagePlan>& plan);
nlohmann::ordered_json representationJson(const ValidatedGenerator& validated, const FigureContext& context);

}  // namespace nlg
