#include "validate/generators/validation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <iterator>
#include <limits>
#include <numeric>
#include <sstream>

#include <fmt/format.h>

#include "bake/load_generators.h"
#include "runtime_eval/evaluator/evaluate.h"
#include "tool/atomic_file.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/provenance.h"
#include "validate/generators/function_counts.h"
#include "validate/generators/summary_json.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSchemaVersion = 2;

uint8_t bitAt(const std::vector<uint8_t>& bits, uint64_t at) { return bits[at / 8] >> (at % 8) & 1; }

// Pixel centres of the plane; a hair off the probe, so that the nearest point is not a tie of mirror images.
std::vector<LocalPoint> planePoints(int axis, int size) {
  std::vector<LocalPoint> points;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      LocalPoint point{};
      point[axis] = 0.003f;
      point[(axis + 1) % 3] = 2.0f * (static_cast<float>(column) + 0.5f) / static_cast<float>(size) - 1.0f;
      point[(axis + 2) % 3] = 2.0f * (static_cast<float>(row) + 0.5f) / static_cast<float>(size) - 1.0f;
      points.push_back(point);
    }
  }
  return points;
}

size_t nearestSupportPoint(const LocalPoint& point) {
  const std::vector<LocalPoint>& support = supportPattern().points;
  size_t nearest = 0;
  float best = std::numeric_limits<float>::max();
  for (size_t i = 0; i < support.size(); ++i) {
    const float dx = support[i][0] - point[0], dy = support[i][1] - point[1], dz = support[i][2] - point[2];
    const float squared = dx * dx + dy * dy + dz * dz;
    if (squared < best) best = squared, nearest = i;
  }
  return nearest;
}

// Score of an axis plane: how far the function is from the bare tent near it, and four times how far the representation is from
// the function.
int mostTellingAxis(const FunctionSet& set, uint64_t index, const AlignedFloats& support_values) {
  constexpr float kSlab = 0.08f;
  double score[3] = {};
  const std::vector<LocalPoint>& support = supportPattern().points;
  for (size_t i = 0; i < support.size(); ++i) {
    const uint64_t at = index * support.size() + i;
    if (!bitAt(set.validity, at)) continue;
    const double phi = set.phi[at] / 255.0;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::fabs(support[i][axis]) < kSlab)
        score[axis] += std::fabs(phi - tent(support[i])) + 4.0 * std::fabs(support_values[i] - phi);
    }
  }
  int best = 1;  // the floor plan, unless another plane says clearly more
  for (const int axis : {0, 2}) {
    if (score[axis] > 1.2 * score[best]) best = axis;
  }
  return best;
}

constexpr int kSlicePixels = 96;

// The tent times a network that says 1.
Theta bareTentTheta() {
  Theta theta(Representation::tentMlp().thetaCount(), 0.0f);
  theta[ThetaLayout::b3] = 1.0f;
  return theta;
}

struct TellingFunction {
  std::string which;  // "p5", "median", "p95", "worst"
  uint64_t function = 0;
};

// A slice of a function: for slices.json.
Json sliceJson(const TellingFunction& telling, const FunctionError& error, const FunctionSet& set,
               const Representation& representation, const float* theta) {
  // the plane through the probe in which the function tells most
  const PointSet support = makePointSet(supportPattern().points);
  AlignedFloats support_values(support.padded_count);
  evaluate(representation, support, theta, support_values.data());
  const int axis = mostTellingAxis(set, telling.function, support_values);
  const std::vector<LocalPoint> plane = planePoints(axis, kSlicePixels);
  const PointSet points = makePointSet(plane);
  AlignedFloats values(points.padded_count);
  evaluate(representation, points, theta, values.data());
  Json slice = {{"which", telling.which},
                {"function", telling.function},
                {"scene", set.scene_ids[set.scene_idx[telling.function]]},
                {"blend_rmse", error.blend_rmse},
                {"rmse", error.rmse},
                {"axis", axis},
                {"size", kSlicePixels}};
  const auto permille = [](float value) { return static_cast<int>(std::lround(1000.0f * std::clamp(value, -2.0f, 2.0f))); };
  std::vector<int> valid, seen, target, stored, difference;
  // beside what theta gives: the target at the nearest support point, since phi is known nowhere else; and the difference there, so
  // that it has no trace of the mosaic
  int pixel = 0;
  for (const LocalPoint& point : plane) {
    const size_t nearest = nearestSupportPoint(point);
    const uint64_t at = telling.function * kSupportPointCount + nearest;
    const float phi = static_cast<float>(set.phi[at]) / 255.0f;
    valid.push_back(bitAt(set.validity, at));
    seen.push_back(bitAt(set.seen, at));
    target.push_back(permille(phi));
    stored.push_back(permille(values[pixel++]));
    difference.push_back(permille(support_values[nearest] - phi));
  }
  slice.update({{"valid", valid},
                {"seen", seen},
                {"target_permille", target},
                {"stored_permille", stored},
                {"difference_permille", difference}});
  return slice;
}

// By the blend RMSE of what is stored, among the hard functions. Where none is hard, among those that take a theta; where none does,
// among all. At a percentile stands the function with the most valid points among those whose ranks lie within a two-hundredth of
// all around it: a picture of solid says nothing.
std::vector<TellingFunction> tellingFunctions(const MeasuredWord& stored, const FunctionSet& set,
                                              const Populations& populations) {
  // hard functions where there are any: bare tents look alike
  std::vector<MeasuredFunction> functions;
  for (const Population population : {Population::hard, Population::theta, Population::all}) {
    std::copy_if(stored.functions.begin(), stored.functions.end(), std::back_inserter(functions),
                 [&](const MeasuredFunction& one) { return populations.contains(Scope::set, population, one.function); });
    if (!functions.empty()) break;
  }
  // by blend RMSE, so that the shares are quantiles of it
  std::stable_sort(functions.begin(), functions.end(),
                   [](const MeasuredFunction& a, const MeasuredFunction& b) { return a.error.blend_rmse < b.error.blend_rmse; });
  const auto validCount = [&](const MeasuredFunction& one) {
    const uint8_t* const validity = functionAt(set, one.function).validity;
    return std::accumulate(validity, validity + set.point_count / 8, 0,
                           [](int sum, uint8_t bits) { return sum + std::popcount(bits); });
  };
  // of functions within half a percent of the rank, the one with most valid points: a picture with something to see
  const auto near = [&](double share) {
    const size_t count = functions.size(), reach = count / 200;
    const auto rank = static_cast<size_t>(share * static_cast<double>(count - 1));
    const auto first = functions.begin() + static_cast<std::ptrdiff_t>(rank - std::min(rank, reach));
    const auto end = functions.begin() + static_cast<std::ptrdiff_t>(std::min(rank + reach + 1, count));
    return std::max_element(first, end, [&](const auto& a, const auto& b) { return validCount(a) < validCount(b); })->function;
  };
  return {{"p5", near(0.05)}, {"median", near(0.5)}, {"p95", near(0.95)}, {"worst", functions.back().function}};
}

// Square pictures of functions, for slices.json (docs/reference/formats.md): of those at the 5th, 50th and 95th percentile of the blend
// RMSE of what is stored, and of the worst; each of that plane through the probe of the three that tells most, function against
// bare tent and representation against function. Rows x columns, local coordinates from -1 to 1.
void appendSlices(const Representation& representation, const PolicyWords& words, const FunctionSet& set,
                  const Populations& populations, Json* slices) {
  const MeasuredWord& stored = words.at(ThetaWord::stored);
  for (const TellingFunction& telling : tellingFunctions(stored, set, populations)) {
    const MadeTheta& made = words.made[telling.function];
    const FunctionError& error = stored.functions[telling.function].error;
    Json entry = made.isBareTent() ? sliceJson(telling, error, set, Representation::tentMlp(), bareTentTheta().data())
                                   : sliceJson(telling, error, set, representation, made.theta.data());
    entry["representation"] = representationName(representation);
    slices->push_back(entry);
  }
}

}  // namespace

int ValidateOptions::threadCount() const { return threads > 0 ? threads : machineThreadCount(); }

void describe(ValidateOptions& o, OptionTable& table) {
  table.group("Measurement");
  table.add("seed", &o.seed, "seed of random starts");
  describePolicy(o.policy, table);
  table.group("Measurement");
  table.add("theta_precision", &o.theta_precision,
            "number format in which the light grid would store theta: float32, float16 or int8", {"float32", "float16", "int8"});
  table.add("hard_tent_rmse", &o.hard_tent_rmse, "RMSE of the bare tent from which a function counts as hard", 0.0, 1.0);
  table.add("direct_functions", &o.direct_functions,
            "number of functions in the sample for long fits: they take a theta, and are spread evenly over scenes", 1, 1000000);
  table.add("direct_adam_steps", &o.direct.adam_steps, "direct optimisation: Adam steps per start", 0, 10000000);
  table.add("direct_lm_iterations", &o.direct.levenberg_iterations, "direct optimisation: LM iterations per start", 0, 100000);
  table.add("direct_restarts", &o.direct.restarts, "direct optimisation: number of random starts", 1, 1000);
  table.add("threads", &o.threads, "number of threads. 0: one per hardware thread. No error depends on it", 0, 1024);
}

void validate(const ValidationRequest& request, ValidateOptions options, const OptionTable& table) {
  // the folder first: a run of hours must not end without a place for its result
  requireOutputFolder(request.out_dir);
  for (const char* name : {"functions.csv", "slices.json", "summary.json"})
    refuseToReplaceOthers(request.out_dir + "/" + name, kValidationFiles);
  options.policy.theta_precision = thetaPrecisionFromName(options.theta_precision);
  const auto [generators, paths] = loadGenerators(request.weights);
  const FunctionSet set = readHeldOut(request.held_out);
  // populations, counts and tents are of the set: all generators are compared on the same functions
  const Populations populations(set, options);
  const FunctionCounts counts = countFunctions(request.training, request.held_out, set, options.threadCount());
  const FigureContext context{set, populations, counts.known};
  const MeasuredWord tents = measureTents(set, populations, options);

  // tables grow generator by generator, and are written together at the end
  std::ostringstream csv;
  csv << kCsvHead;
  appendCsv(tents.name, tents, set, populations, csv);
  Json slices = Json::array();
  Json summary = {{"schema_version", kSchemaVersion},
                  {"provenance", provenance("nlg-validate", table.toJson(), {{"held_out", set.sha256}})},
                  {"tau", tauJson(options)},
                  {"theta_precision", thetaPrecisionName(options.policy.theta_precision)},
                  {"functions", functionsJson(counts.all, context)},
                  {"in_training", inTrainingJson(context)},
                  {"bootstrap", bootstrapJson(context)},
                  {tents.name, figuresByPopulation(tents, Scope::set, context)}};
  // for each generator the bake's policy, long fits from its thetas, and slices of telling functions
  for (size_t i = 0; i < generators.size(); ++i) {
    const Representation& representation = generators[i].representation();
    const std::string name = representationName(representation);
    PolicyWords policy = measurePolicy(generators[i], set, populations, options);
    LongFits fits = measureLongFits(generators[i], set, populations, policy.least_wrong, options);
    const ValidatedGenerator validated{generators[i], paths[i], std::move(policy), std::move(fits)};
    summary["representations"][name] = representationJson(validated, context);
    for (const MeasuredWord& word : validated.policy.words) appendCsv(name, word, set, populations, csv);
    for (const MeasuredWord& fit : validated.fits.words) appendCsv(name, fit, set, populations, csv);
    appendSlices(representation, validated.policy, set, populations, &slices);
  }
  writeFileAtomically(request.out_dir + "/functions.csv", csv.str());
  writeFileAtomically(request.out_dir + "/slices.json", slices.dump());
  writeFileAtomically(request.out_dir + "/summary.json", summary.dump(1) + "\n");
  std::cout << request.out_dir << "/summary.json\n";
  for (const auto& [name, node] : summary["representations"].items()) {
    const Json& stored = node["stored"]["theta"];
    if (stored["functions"] == 0) continue;
    std::cout << fmt::format(
        "{}: mean blend RMSE {:.4f}, {:.1f} % fail the check, of {} functions that take a theta, as stored\n", name,
        stored["blend_rmse"]["mean"].get<double>(), 100.0 * stored["share_failing_check"]["value"].get<double>(),
        stored["functions"].get<uint64_t>());
  }
}

}  // namespace nlg
