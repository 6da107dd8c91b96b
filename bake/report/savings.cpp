#include "bake/report/bake_report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/policy/stage_plan.h"

namespace nlg {
namespace {

// Nothing of nothing: what was not done has no price.
std::optional<double> each(double sum, uint64_t count) {
  return count > 0 ? std::optional(sum / static_cast<double>(count)) : std::nullopt;
}

std::optional<double> times(uint64_t count, const std::optional<double>& unit, double less = 0.0) {
  return unit ? std::optional(static_cast<double>(count) * *unit - less) : std::nullopt;
}

std::optional<double> sum(const std::optional<double>& a, const std::optional<double>& b) {
  return a && b ? std::optional(*a + *b) : std::nullopt;
}

double thetaSeconds(const BakeStatistics& statistics) {
  double theta_us = 0.0;
  for (const FunctionOutcome& function : statistics.functions) theta_us += function.record.elapsedUs(ThetaWord::stored);
  return 1e-6 * theta_us;
}

// Of a theta in the file; before any is stored, of one in the smallest representation without the file's code.
double thetaBytes(const LightGrid& grid, const Representation& smallest, const GridPrecision& stored,
                  const LightGridBytes& bytes) {
  const std::optional<double> mean = each(static_cast<double>(bytes.theta), grid.functionCount());
  return mean ? *mean : static_cast<double>(thetaForm(smallest, stored.theta).bytes());
}

}  // namespace

std::vector<Saving> savingsOf(const Bake& bake, const std::vector<Generator>& generators, const PolicyOptions& policy,
                              const GridPrecision& stored, const std::vector<uint64_t>& weights_bytes, int threads) {
  std::vector<Saving> savings;
  const auto add = [&](const char* what, uint64_t count, uint64_t of, std::optional<double> seconds, std::optional<double> bytes,
                       std::string note) {
    savings.push_back({what, count, of, seconds, bytes ? std::optional(std::llround(*bytes)) : std::nullopt, std::move(note)});
  };
  const BakeStatistics& statistics = bake.statistics;
  const ShardCounts& counts = statistics.counts;
  const FunctionTimes& spent = statistics.function_times;
  const LightGridBytes bytes = lightGridBytes(bake.grid, stored);  // once: light is coded for it
  const uint64_t probes = counts.grid_probes, tents = statistics.bare_tents.count;
  // probes that went all the way, 0 everywhere or not
  const uint64_t generated = counts.functions + counts.duplicates + counts.empty + tents;
  // of the processor: of a probe that has a function, of a function that has a theta, and of any probe but for its light
  const std::optional<double> visibility_s = each(spent.visibility_s - spent.in_solid_s, generated),
                              function_s = each(spent.functions_s + spent.bare_tent_s, generated),
                              theta_s = each(thetaSeconds(statistics), counts.functions),
                              probe_s = each(spent.visibility_s + spent.functions_s + spent.bare_tent_s + spent.duplicates_s +
                                                 thetaSeconds(statistics),
                                             probes);
  const double theta_bytes = thetaBytes(bake.grid, generators.front().representation(), stored, bytes);

  // cells and probes that nobody looks up in
  const AirStatistics& air = statistics.air;
  if (air.airless_cells > 0) {
    // by the clock while every thread measured
    const LightStatistics& light = statistics.light;
    const std::optional<double> light_s =
        light.is_lit ? each(light.measure_wall_s * threads, air.cells - air.airless_cells) : std::nullopt;
    add("cells without air", air.airless_cells, air.cells, times(air.airless_cells, light_s), {},
        "air_only; seconds: light at as many sample points as other cells have");
    const uint64_t unread = air.probes - probes;
    add("probes that only cells without air read", unread, air.probes, times(unread, probe_s),
        times(unread, each(static_cast<double>(bytes.total()), probes)), "air_only; each as the mean probe of this bake");
  }

  // probes without a theta of their own
  const auto thetas = [&](uint64_t count) { return static_cast<double>(count) * theta_bytes; };
  add("probes in free space", counts.free_space, probes, times(counts.free_space, function_s), 0,
      "no function: the bare tent, exactly. Their visibility is not counted: where no triangle is near it is next to nothing");
  add("probes in solid", counts.in_solid, probes,
      times(counts.in_solid, sum(sum(visibility_s, function_s), theta_s), spent.in_solid_s), thetas(counts.in_solid),
      "without an eye in air: no links, function or theta; less what it took to look for the eye");
  add("probes whose function is 0 everywhere", counts.empty, probes, times(counts.empty, theta_s), thetas(counts.empty),
      "no theta");
  add("duplicates", counts.duplicates, probes, times(counts.duplicates, theta_s, spent.duplicates_s), thetas(counts.duplicates),
      "one theta for all that are alike; less what it took to find them");
  add("functions that are all but the bare tent", tents, tents + counts.duplicates + counts.functions,
      times(tents, theta_s, spent.bare_tent_s), thetas(tents),
      "bare_tent_rmse: no theta, and nothing to evaluate in the look-up; less what it took to find out");

  // what functions and weights need less of
  std::vector<std::string_view> never_chosen;
  uint64_t never_bytes = 0;
  const std::vector<uint64_t> chosen = statistics.chosen(generators.size());
  for (size_t g = 0; g < generators.size(); ++g) {
    if (chosen[g] > 0) continue;
    never_chosen.push_back(representationName(generators[g].representation()));
    never_bytes += weights_bytes[g];
  }
  add("representations never chosen", never_chosen.size(), generators.size(), {}, static_cast<double>(never_bytes),
      never_chosen.empty() ? "every one of them has a function"
                           : fmt::format("{}: not in the light grid", fmt::join(never_chosen, ", ")));
  uint64_t good = 0, unrefined = 0;
  for (const FunctionOutcome& function : statistics.functions) {
    const ThetaRecord& record = function.record;
    good += isGood(record.at(ThetaWord::network), policy.good_rmse, policy.check());
    unrefined += !record.refined && record.at(ThetaWord::fitted).passes(policy.check());
  }
  const double stages_s = statistics.wordSeconds(ThetaWord::corrected) + statistics.wordSeconds(ThetaWord::fitted);
  add("corrections and fits of thetas that are good", good, counts.functions,
      times(good, each(stages_s, counts.functions - good)), 0, "good_rmse: what the network left so takes no other stage");
  // no seconds: the few that were refined are the hardest, and their cost says nothing about functions that pass
  add("refinements", unrefined, counts.functions, {}, 0, "the check passes before");
  return savings;
}

nlohmann::ordered_json toJson(const std::vector<Saving>& savings) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Saving& saving : savings) {
    nlohmann::ordered_json row = {{"what", saving.what}, {"count", saving.count}, {"of", saving.of}};
    if (saving.seconds) row["seconds_saved"] = *saving.seconds;
    if (saving.bytes) row["bytes_saved"] = *saving.bytes;
    row["note"] = saving.note;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace nlg
