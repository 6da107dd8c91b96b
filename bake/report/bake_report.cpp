#include "bake/report/bake_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "tool/printable.h"

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

// Of the thetas of all functions, at a word.
nlohmann::ordered_json errorsJson(const BakeReport& report, ThetaWord word) {
  std::vector<double> rmse;
  double sum = 0.0, leak_sum = 0.0, elapsed_us = 0.0;
  for (const FunctionOutcome& function : report.statistics.functions) {
    const ThetaRecord& record = function.record;
    rmse.push_back(record.at(word).rmse);
    sum += record.at(word).rmse;
    leak_sum += record.at(word).leak_mean;
    elapsed_us += record.elapsedUs(word);
  }
  const double count = std::max<double>(1.0, static_cast<double>(rmse.size()));
  return {{"mean", sum / count},
          {"median", quantile(rmse, 0.5)},
          {"p95", quantile(rmse, 0.95)},
          {"p99", quantile(rmse, 0.99)},
          {"worst", quantile(rmse, 1.0)},
          {"leak_mean", leak_sum / count},
          {"failing", report.statistics.failing(word, report.policy.check())},
          {"us_per_function", elapsed_us / count}};
}

constexpr ThetaWord kWords[] = {ThetaWord::network, ThetaWord::corrected, ThetaWord::fitted, ThetaWord::stored};

nlohmann::ordered_json thinnedJson(const LightStatistics& light) {
  if (light.thin_error == 0.0) return nullptr;
  const Thinned& thinned = light.thinned;
  return {{"error", light.thin_error},
          {"functions", thinned.functions},
          {"probes", thinned.probes},
          {"distinct_functions", light.functions_thinned},
          {"largest_change", thinned.largest_change},
          {"largest_at_m", {thinned.largest_at_m.x, thinned.largest_at_m.y, thinned.largest_at_m.z}}};
}

std::string thinnedSummary(const LightStatistics& light) {
  if (light.thin_error == 0.0) return {};
  const glm::dvec3 at = glm::round(10.0 * light.thinned.largest_at_m) / 10.0 + 0.0;
  return fmt::format(
      "thinned by {:.2g}: {} left out, and the functions of {} others; {} of {} functions stay; the error grows most, by {:.2g} "
      "of "
      "the light, at {:.1f}, {:.1f}, {:.1f}\n",
      light.thin_error, countText(light.thinned.probes, "probe"), light.thinned.functions, light.functions_thinned,
      light.functions_whole, light.thinned.largest_change, at.x, at.y, at.z);
}

nlohmann::ordered_json atPlacesJson(const LightAtPlaces& light) {
  return {{"mean_radiance", light.mean},
          {"error", light.error},
          {"median_error", light.median_error},
          {"p95_error", light.p95_error},
          {"worst_m", {light.worst_m.x, light.worst_m.y, light.worst_m.z}}};
}

nlohmann::ordered_json darkRoomsJson(const std::vector<DarkRoom>& rooms) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const DarkRoom& room : rooms)
    json.push_back({{"eye_m", {room.eye_m.x, room.eye_m.y, room.eye_m.z}}, {"volume_m3", room.volume_m3}});
  return json;
}

nlohmann::ordered_json lightJson(const LightStatistics& light) {
  if (!light.is_lit) return nullptr;
  nlohmann::ordered_json json = {
      {"groups", light.groups},
      {"gathered", light.is_gathered},
      {"bytes", light.file_bytes},
      {"packing_error", light.packing.error},
      {"packing_worst", light.packing.worst},
      {"places", light.places},
      {"unseen_places", light.unseen_places},
      {"rays_per_place", light.rays_per_place},
      {"cache_cells", light.cache_cells},
      {"cache_divided", light.cache_divided},
      {"thinned", thinnedJson(light)},
      {"unread_probes", light.unread_probes},
      {"dark_rooms", darkRoomsJson(light.dark_rooms)},
      {"solve_iterations", light.solve_iterations},
      {"wall_seconds", {{"cache", light.cache_wall_s}, {"measure", light.measure_wall_s}, {"solve", light.solve_wall_s}}}};
  json.update(atPlacesJson(light));
  return json;
}

std::string firstLine(const std::string& path, uint64_t probes, uint64_t file_bytes, double wall_s, uint64_t memory_bytes) {
  return fmt::format("{}: {}, {}, {}; {} of memory\n", path, countText(probes, "probe"),
                     bytesText(static_cast<double>(file_bytes)), durationText(wall_s),
                     bytesText(static_cast<double>(memory_bytes)));
}

std::string placesSummary(uint64_t places, const LightAtPlaces& light) {
  const glm::dvec3 worst = glm::round(10.0 * light.worst_m) / 10.0 + 0.0;  // no -0.0
  return fmt::format(
      "light: at {} the grid is off by {:.1f} % in the median and by {:.0f} % at the 95th percentile, noise of measuring them "
      "included; most at {:.1f}, {:.1f}, {:.1f}; mean radiance {:.3g}\n",
      countText(places, "sample point"), 100.0 * light.median_error, 100.0 * light.p95_error, worst.x, worst.y, worst.z,
      light.mean);
}

std::string lightSummary(const LightStatistics& light) {
  if (!light.is_lit) return "light: none\n";
  std::string text = thinnedSummary(light);
  const uint64_t seen = light.places - light.unseen_places;
  if (seen > 0) text += placesSummary(seen, light);
  if (light.unseen_places > 0) {
    text += fmt::format(
        "{} of {} are dark and lie in hollows or outside of all rooms, where nobody looks: light is not fitted there\n",
        countText(light.unseen_places), countText(light.places, "sample point"));
  }
  return text + fmt::format("stored light: {}, which adds {:.1f} % to the error of a probe, {:.0f} % at most{}\n",
                            bytesText(static_cast<double>(light.file_bytes)), 100.0 * light.packing.error,
                            100.0 * light.packing.worst,
                            light.groups.empty() ? std::string() : fmt::format("; in groups: {}", fmt::join(light.groups, ", ")));
}

std::string notesSummary(size_t notes) {
  return notes > 0 ? fmt::format("what was not read, or read otherwise: {}, above\n", countText(notes, "note")) : std::string();
}

}  // namespace

nlohmann::ordered_json toJson(const BakeReport& report) {
  const BakeStatistics& s = report.statistics;
  const ShardCounts& counts = s.counts;
  nlohmann::ordered_json chosen, weights;
  for (size_t i = 0; i < report.weights.size(); ++i) {
    const WeightsUsed& used = report.weights[i];
    chosen[used.representation] = s.chosen(report.weights.size())[i];
    weights[used.representation] = {{"sha256", used.sha256}, {"bytes", used.bytes}};
  }
  nlohmann::ordered_json stops, ended, stage_seconds, words;
  // every reason has its key, also where no fit stopped for it
  for (int stop = 0; stop < kFitStopCount; ++stop) stops[fitStopName(static_cast<FitStop>(stop))] = 0;
  for (const FunctionOutcome& function : s.functions) {
    const ThetaRecord& record = function.record;
    if (record.refined)
      stops[fitStopName(record.refinement_stop)] = stops[fitStopName(record.refinement_stop)].get<int64_t>() + 1;
  }
  for (int stage = 0; stage < kThetaStageCount; ++stage) {
    const auto name = static_cast<ThetaStage>(stage);
    ended[stageName(name)] =
        std::count_if(s.functions.begin(), s.functions.end(), [&](const FunctionOutcome& f) { return f.record.ended == name; });
    stage_seconds[stageName(name)] = s.stageSeconds(name);
  }
  // of all functions, also those that have no theta for it
  stage_seconds[stageName(ThetaStage::bare_tent)] = s.function_times.bare_tent_s;
  for (const ThetaWord word : kWords) words[wordName(word)] = errorsJson(report, word);
  const uint64_t with_tents = counts.functions + s.bare_tents.count;
  return {{"scene", report.scene},
          {"probes", counts.grid_probes},
          {"free_space", counts.free_space},
          {"bare_tents", s.bare_tents.count},
          {"bare_tent_rmse_mean", s.bare_tents.meanRmse()},
          {"in_solid", counts.in_solid},
          {"solid_functions", counts.solid_functions},
          {"cavity_probes", s.function_times.cavity_probes},
          {"empty", counts.empty},
          {"duplicates", counts.duplicates},
          {"functions", counts.functions},
          {"air",
           {{"cells", s.air.cells},
            {"airless_cells", s.air.airless_cells},
            {"probes_before", s.air.probes},
            {"places_drawn", s.air.drawn},
            {"places_in_cavities", s.air.in_cavities},
            {"wall_s", s.air.wall_s}}},
          {"light", lightJson(s.light)},
          {"representations", chosen},
          {"weights", weights},
          {"thread_seconds",
           {{"visibility", s.function_times.visibility_s},
            {"functions", s.function_times.functions_s},
            {"duplicates", s.function_times.duplicates_s},
            {"stages", stage_seconds}}},
          {"wall_seconds",
           {{"load", s.load_wall_s}, {"functions", s.functions_wall_s}, {"refinement", s.refinement_wall_s}, {"all", s.wall_s}}},
          {"threads", report.threads},
          {"simd", report.simd},
          {"tau_rmse", report.policy.check().tau_rmse},
          {"rmse", words},
          {"blend", toJson(s.blend)},
          {"took_fit", s.tookFit()},
          {"share_fitted", {{"all", share(s.tookFit(), with_tents)}, {"theta", share(s.tookFit(), counts.functions)}}},
          {"ended", ended},
          {"refined", s.refined()},
          {"refinement_stops", stops},
          {"left_for_time", s.left_for_time},
          {"raised", s.raised()},
          {"still_failing", s.failing(ThetaWord::stored, report.policy.check())},
          {"bytes", report.file_bytes},
          {"theta_bytes", report.theta_bytes},
          {"bytes_per_probe",
           static_cast<double>(report.file_bytes) / std::max<double>(1.0, static_cast<double>(counts.grid_probes))},
          {"peak_memory_bytes", report.peak_memory_bytes},
          {"savings", toJson(report.savings)}};
}

std::string toSummary(const BakeReport& report, const std::string& path) {
  const BakeStatistics& s = report.statistics;
  std::string text = firstLine(path, s.counts.grid_probes, report.file_bytes, s.load_wall_s + s.wall_s, report.peak_memory_bytes);
  text += countText(s.counts.functions, "function").append(" stored");
  if (s.counts.functions > 0) {
    const nlohmann::ordered_json errors = errorsJson(report, ThetaWord::stored);
    text += fmt::format("; RMSE {:.4f} on average, 95th percentile {:.4f}", errors.at("mean").get<double>(),
                        errors.at("p95").get<double>());
  }
  const uint64_t failing = s.failing(ThetaWord::stored, report.policy.check());
  if (failing > 0) text += fmt::format("; {} of them fail the check, which light seldom shows", failing);
  if (s.left_for_time > 0) text += fmt::format("; {} left for want of time", s.left_for_time);
  return text + '\n' + lightSummary(s.light) + notesSummary(report.notes);
}

nlohmann::ordered_json toJson(const RelightReport& report) {
  return {{"scene", report.scene},
          {"relit", report.grid},
          {"probes", report.probes},
          {"light", lightJson(report.light)},
          {"wall_seconds", {{"all", report.wall_s}}},
          {"bytes", report.file_bytes},
          {"peak_memory_bytes", report.peak_memory_bytes}};
}

std::string toSummary(const RelightReport& report, const std::string& path) {
  return firstLine(path, report.probes, report.file_bytes, report.wall_s, report.peak_memory_bytes) +
         fmt::format("functions as in {}\n", report.grid) + lightSummary(report.light) + notesSummary(report.notes);
}

}  // namespace nlg
