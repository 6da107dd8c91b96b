#include "bake/bake_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace nlg {
namespace {

double share(uint64_t part, uint64_t whole) { return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0; }

// The q-quantile, the higher of two neighbours; 0 of nothing.
double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<ptrdiff_t>(std::min(q * static_cast<double>(values.size()), values.size() - 1.0));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

nlohmann::ordered_json errorsJson(const std::vector<FunctionCheck>& checks) {
  std::vector<double> rmse;
  double sum = 0.0, leak_sum = 0.0;
  for (const FunctionCheck& check : checks) {
    rmse.push_back(check.rmse);
    sum += check.rmse;
    leak_sum += check.leak_mean;
  }
  const double count = std::max<double>(1.0, static_cast<double>(checks.size()));
  return {{"mean", sum / count},         {"median", quantile(rmse, 0.5)}, {"p95", quantile(rmse, 0.95)},
          {"p99", quantile(rmse, 0.99)}, {"worst", quantile(rmse, 1.0)},  {"leak_mean", leak_sum / count}};
}

}  // namespace

nlohmann::ordered_json toJson(const BakeReport& report) {
  const BakeStatistics& s = report.statistics;
  const ShardCounts& counts = s.counts;
  nlohmann::ordered_json chosen;
  for (size_t i = 0; i < report.representations.size(); ++i) chosen[report.representations[i]] = s.chosen[i];
  nlohmann::ordered_json weights;
  for (size_t i = 0; i < report.weights.size(); ++i)
    weights[report.representations[i]] = {{"sha256", report.weights[i].sha256}, {"bytes", report.weights[i].bytes}};
  nlohmann::ordered_json stops;
  for (int stop = 0; stop < kFitStopCount; ++stop) stops[fitStopName(static_cast<FitStop>(stop))] = s.refinement_stops[stop];
  return {{"scene", report.scene},
          {"probes", counts.grid_probes},
          {"free_space", counts.free_space},
          {"bare_tents", s.bare_tents.count},
          {"bare_tent_rmse_mean", s.bare_tents.meanRmse()},
          {"in_solid", counts.in_solid},
          {"empty", counts.empty},
          {"duplicates", counts.duplicates},
          {"functions", counts.functions},
          {"representations", chosen},
          {"weights", weights},
          {"thread_seconds",
           {{"visibility", s.function_times.visibility_s},
            {"functions", s.function_times.functions_s},
            {"duplicates", s.function_times.duplicates_s},
            {"generator", s.generator_s},
            {"check", s.check_s},
            {"correction", s.correction_s},
            {"refinement", s.refinement_s}}},
          {"wall_seconds",
           {{"load", s.load_wall_s}, {"functions", s.functions_wall_s}, {"refinement", s.refinement_wall_s}, {"all", s.wall_s}}},
          {"threads", report.threads},
          {"simd", report.simd},
          {"tau_rmse", report.check.tau_rmse},
          {"corrected", s.corrected},
          {"failed_check", s.failed_check},
          {"refined", s.refined},
          {"refinement_stops", stops},
          {"left_for_time", s.left_for_time},
          {"raised", s.raised},
          {"still_failing", s.still_failing},
          {"rmse_generated", errorsJson(s.generated)},
          {"rmse_stored", errorsJson(s.stored)},
          {"rmse_added_by_rounding", {{"mean", report.rounding.mean_rmse_added}, {"worst", report.rounding.worst_rmse_added}}},
          {"bytes", report.file_bytes},
          {"theta_bytes", report.theta_bytes},
          {"bytes_per_probe",
           static_cast<double>(report.file_bytes) / std::max<double>(1.0, static_cast<double>(counts.grid_probes))},
          {"peak_memory_bytes", report.peak_memory_bytes},
          {"needs", toJson(report.needs)}};
}

std::string toTable(const BakeReport& report) {
  const BakeStatistics& s = report.statistics;
  const ShardCounts& counts = s.counts;
  const nlohmann::ordered_json generated = errorsJson(s.generated), stored = errorsJson(s.stored);
  const auto number = [](const nlohmann::ordered_json& json, const char* key) { return json.at(key).get<double>(); };
  std::string text =
      fmt::format("{:>9} {:>12} {:>12} {:>10} {:>11} {:>8} {:>11} {:>16} {:>12} {:>9} {:>8}\n", "probes", "visibility",
                  "functions", "functions", "generator", "check", "correction", "refined", "refinement", "bytes", "a probe");
  text += fmt::format(
      "{:>9} {:>10.2f} s {:>10.2f} s {:>10} {:>9.2f} s {:>6.2f} s {:>9.2f} s {:>7} ({:>4.1f} %) {:>10.2f} s {:>6.1f} MB "
      "{:>8.1f}\n",
      counts.grid_probes, s.function_times.visibility_s, s.function_times.functions_s, counts.functions, s.generator_s, s.check_s,
      s.correction_s, s.refined, 100.0 * share(s.refined, counts.functions), s.refinement_s,
      static_cast<double>(report.file_bytes) * 1e-6,
      static_cast<double>(report.file_bytes) / std::max<double>(1.0, static_cast<double>(counts.grid_probes)));
  text += fmt::format(
      "seconds are summed over threads; {:.2f} s by the clock on {} threads ({}), {:.2f} s of them to load the scene\n",
      s.load_wall_s + s.wall_s, report.threads, report.simd, s.load_wall_s);
  text += fmt::format(
      "probes: {} free space, {} all but the bare tent, {} in solid, {} without weight, {} duplicates ({:.2f} s to find)\n",
      counts.free_space, s.bare_tents.count, counts.in_solid, counts.empty, counts.duplicates, s.function_times.duplicates_s);
  text += fmt::format("RMSE: generated mean {:.4f}, p95 {:.4f}; stored mean {:.4f}, p95 {:.4f}, worst {:.4f}\n",
                      number(generated, "mean"), number(generated, "p95"), number(stored, "mean"), number(stored, "p95"),
                      number(stored, "worst"));
  if (s.bare_tents.count > 0) {
    text += fmt::format("all but the bare tent: RMSE mean {:.4f}, in none of the figures above\n", s.bare_tents.meanRmse());
  }
  if (s.corrected > 0) text += fmt::format("{} predicted thetas were corrected\n", s.corrected);
  if (s.still_failing > 0 || s.left_for_time > 0) {
    text += fmt::format("{} functions still fail the check ({:.2f} %), {} of all were left for want of time\n", s.still_failing,
                        100.0 * share(s.still_failing, counts.functions), s.left_for_time);
  }
  if (report.representations.size() > 1) {
    text += "representations:";
    for (size_t i = 0; i < report.representations.size(); ++i)
      text += fmt::format(" {} {}", report.representations[i], s.chosen[i]);
    text += fmt::format("; {} raised in refinement\n", s.raised);
  }
  if (!report.needs.empty()) text += toTable(report.needs);
  return text;
}

}  // namespace nlg
