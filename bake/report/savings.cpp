#include "bake/report/savings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/policy/stage_plan.h"

namespace nlg {
namespace {

// Nothing of nothing: what was not done has no price.
std::optional<double> each(double sum, uint64_t count) {
  return count > 0 ? std::optional(sum / static_cast<double>(count)) : std::nullopt;
}

std::optional<double> times(uint64_t count, const std::optional<double>& unit) {
  return unit ? std::optional(static_cast<double>(count) * *unit) : std::nullopt;
}

std::optional<double> sum(const std::optional<double>& a, const std::optional<double>& b) {
  return a && b ? std::optional(*a + *b) : std::nullopt;
}

// Probes that have a function, 0 everywhere or not, and were seen in this bake.
uint64_t generatedProbes(const BakeStatistics& s) {
  const ShardCounts& counts = s.counts;
  return counts.functions + counts.duplicates + counts.empty + s.bare_tents.count;
}

// What one of each kind took in this bake. Seconds of the processor.
struct UnitCosts {
  explicit UnitCosts(const BakeStatistics& s) {
    const ShardCounts& counts = s.counts;
    const FunctionTimes& spent = s.function_times;
    // probes that went all the way: 0 everywhere or not
    const uint64_t generated = generatedProbes(s);
    visibility_s = each(spent.visibility_s - spent.in_solid_s, generated);
    function_s = each(spent.functions_s + spent.bare_tent_s, generated);
    double theta_us = 0.0;
    for (const FunctionOutcome& function : s.functions) theta_us += function.record.elapsedUs(ThetaWord::stored);
    theta_s = each(1e-6 * theta_us, counts.functions);
    probe_s = each(spent.visibility_s + spent.functions_s + spent.bare_tent_s + spent.duplicates_s + 1e-6 * theta_us,
                   counts.grid_probes);
  }

  std::optional<double> visibility_s, function_s;  // of a probe that has a function
  std::optional<double> theta_s;                   // of a function that has a theta: from the network to what is stored
  std::optional<double> probe_s;                   // of any probe, but for its light
};

class SavingsCount {
 public:
  SavingsCount(const Bake& bake, const std::vector<Generator>& generators, const PolicyOptions& policy,
               const GridPrecision& stored, const std::vector<uint64_t>& weights_bytes, int threads)
      : grid_(bake.grid),
        statistics_(bake.statistics),
        counts_(bake.statistics.counts),
        generators_(generators),
        policy_(policy),
        stored_(stored),
        weights_bytes_(weights_bytes),
        threads_(threads),
        unit_(bake.statistics),
        bytes_(lightGridBytes(bake.grid, stored)) {
    size_t plain_bytes = 0;
    for (size_t f = 0; f < grid_.functionCount(); ++f) plain_bytes += plainBytesOf(f);
    if (plain_bytes > 0) coded_share_ = static_cast<double>(bytes_.theta) / static_cast<double>(plain_bytes);
  }

  std::vector<Saving> run() {
    addAir();
    addProbes();
    addGeometry();
    addRepresentations();
    addFits();
    addLight();
    return std::move(savings_);
  }

 private:
  void add(const char* what, uint64_t count, uint64_t of, std::optional<double> seconds, std::optional<int64_t> bytes,
           std::string note) {
    savings_.push_back({what, count, of, seconds, bytes, std::move(note)});
  }

  // What a function takes in the file: its share of theta, by the bytes that it has before the file's code.
  double bytesOf(size_t function) const { return coded_share_ * static_cast<double>(plainBytesOf(function)); }
  size_t plainBytesOf(size_t function) const {
    const Representation& representation = grid_.representations[grid_.function_representation[function]];
    return storedThetaBytes(representation, stored_.theta, grid_.functionTheta(function));
  }

  // What a function of a representation would take: a code as much as the mean of those that this bake has, if it has any.
  double bytesOf(const Representation& representation) const {
    double sum = 0.0;
    size_t count = 0;
    for (size_t f = 0; f < grid_.functionCount() && representation.isCode(); ++f) {
      const Representation& own = grid_.representations[grid_.function_representation[f]];
      if (!own.isCode() || own.code_count != representation.code_count) continue;
      sum += bytesOf(f);
      ++count;
    }
    return count > 0 ? sum / static_cast<double>(count)
                     : coded_share_ * static_cast<double>(thetaForm(representation, stored_.theta).bytes());
  }

  void addAir() {
    const AirStatistics& air = statistics_.air;
    if (air.airless_cells == 0) return;
    const LightStatistics& light = statistics_.light;
    // by the clock while every thread measured
    const std::optional<double> light_s =
        light.is_lit ? each(light.measure_wall_s * threads_, air.cells - air.airless_cells) : std::nullopt;
    add("cells without air", air.airless_cells, air.cells, times(air.airless_cells, light_s), {},
        "air_only; seconds: light at as many sample points as other cells have");
    const uint64_t unread = air.probes - counts_.grid_probes;
    const std::optional<double> probe_bytes = each(static_cast<double>(bytes_.total()), counts_.grid_probes);
    const std::optional<double> bytes = times(unread, probe_bytes);
    add("probes that only cells without air read", unread, air.probes, times(unread, unit_.probe_s),
        bytes ? std::optional(static_cast<int64_t>(*bytes)) : std::nullopt, "air_only; each as the mean probe of this bake");
  }

  void addProbes() {
    const uint64_t probes = counts_.grid_probes, tents = statistics_.bare_tents.count;
    const FunctionTimes& spent = statistics_.function_times;
    const double theta_bytes = bytesOf(generators_.front().representation());
    const auto thetas = [&](uint64_t count) {
      return static_cast<int64_t>(std::lround(static_cast<double>(count) * theta_bytes));
    };
    add("probes in free space", counts_.free_space, probes, times(counts_.free_space, unit_.function_s), 0,
        "no function: the bare tent, exactly. Their visibility is not counted: where no triangle is near it is next to nothing");
    // what a probe in solid would have taken, by the mean of those that have a theta
    const std::optional<double> whole = sum(sum(unit_.visibility_s, unit_.function_s), unit_.theta_s);
    add("probes in solid", counts_.in_solid, probes, sum(times(counts_.in_solid, whole), -spent.in_solid_s),
        thetas(counts_.in_solid), "without an eye in air: no links, function or theta; less what it took to look for the eye");
    add("probes whose function is 0 everywhere", counts_.empty, probes, times(counts_.empty, unit_.theta_s),
        thetas(counts_.empty), "no theta");
    add("duplicates", counts_.duplicates, probes, sum(times(counts_.duplicates, unit_.theta_s), -spent.duplicates_s),
        thetas(counts_.duplicates), "one theta for all that are alike; less what it took to find them");
    add("functions that are all but the bare tent", tents, tents + counts_.duplicates + counts_.functions,
        sum(times(tents, unit_.theta_s), -spent.bare_tent_s), thetas(tents),
        "bare_tent_rmse: no theta, and nothing to evaluate in the look-up; less what it took to find out");
  }

  void addGeometry() {
    const uint64_t triangles = statistics_.scene_triangles, tested = statistics_.function_times.triangles;
    const uint64_t seen = generatedProbes(statistics_);
    if (seen == 0) return;
    add("triangles that a probe's support does not touch", seen * triangles - tested, seen * triangles, {}, {},
        "of every triangle for every probe that has a function");
  }

  void addRepresentations() {
    const uint64_t functions = counts_.functions;
    const std::vector<uint64_t> chosen = statistics_.chosen(generators_.size());
    if (generators_.size() > 1) {
      const auto larger = static_cast<uint64_t>(std::count_if(statistics_.functions.begin(), statistics_.functions.end(),
                                                              [](const FunctionOutcome& f) { return f.larger_ran; }));
      add("functions that the smallest representation already fits", functions - larger, functions, {}, {},
          fmt::format("only the generator of {} ran for them", representationName(generators_.front().representation())));
      const Representation& largest = generators_.back().representation();
      // the largest for every function, less what is stored
      double bytes = static_cast<double>(grid_.functionCount()) * bytesOf(largest);
      for (size_t f = 0; f < grid_.functionCount(); ++f) bytes -= bytesOf(f);
      add("theta of the largest representation", functions - chosen.back(), functions, {}, std::lround(bytes),
          fmt::format("against {} alone, for every function", representationName(largest)));
    }
    // weights of generators that no function of this scene has chosen
    std::vector<std::string> names;
    uint64_t bytes = 0;
    for (size_t g = 0; g < generators_.size(); ++g) {
      if (chosen[g] > 0) continue;
      names.emplace_back(representationName(generators_[g].representation()));
      bytes += weights_bytes_[g];
    }
    add("representations never chosen", names.size(), generators_.size(), {}, static_cast<int64_t>(bytes),
        names.empty() ? "every one of them has a function" : fmt::format("{}: not in the light grid", fmt::join(names, ", ")));
    if (stored_.theta != ThetaPrecision::float32) {
      const auto floats = static_cast<int64_t>(grid_.theta.size() * sizeof(float));
      add("bits of theta beyond its stored form", grid_.theta.size(), grid_.theta.size(), {},
          floats - static_cast<int64_t>(bytes_.theta),
          fmt::format("theta_precision: {}, against float32", thetaPrecisionName(stored_.theta)));
    }
  }

  void addFits() {
    uint64_t good = 0, unrefined = 0;
    for (const FunctionOutcome& function : statistics_.functions) {
      const ThetaRecord& record = function.record;
      good += isGood(record.at(ThetaWord::network), policy_.good_rmse, policy_.check());
      unrefined += !record.refined && record.at(ThetaWord::fitted).passes(policy_.check());
    }
    const double stages_s = statistics_.wordSeconds(ThetaWord::corrected) + statistics_.wordSeconds(ThetaWord::fitted);
    add("corrections and fits of thetas that are good", good, counts_.functions,
        times(good, each(stages_s, counts_.functions - good)), 0, "good_rmse: what the network left so takes no other stage");
    // no seconds: the few that were refined are the hardest, and their cost says nothing about functions that pass
    add("refinements", unrefined, counts_.functions, {}, 0, "the check passes before");
  }

  void addLight() {
    const LightStatistics& light = statistics_.light;
    if (!light.is_lit) return;
    const uint64_t rays = light.places * light.rays_per_place;
    if (light.is_gathered)
      add("bounces that the level's own light holds", rays, rays, {}, 0, "one ray ends where the level's compiler left them all");
    if (light.cache_cells > 0)
      add("bounces traced once for all probes", light.cache_cells - light.cache_divided, light.cache_cells, {}, 0,
          "light_cache: paths end at these cells of surface; walls divide the others");
    const auto full = static_cast<int64_t>(sizeof(float)) * kShFloats;
    add("bits and coefficients of light beyond the level's own axes", counts_.grid_probes, counts_.grid_probes, {},
        static_cast<int64_t>(counts_.grid_probes) * full - static_cast<int64_t>(light.file_bytes),
        fmt::format("light_error: adds {:.3f} of a probe's light; against 27 floats a probe", light.packing.error));
  }

  const LightGrid& grid_;
  const BakeStatistics& statistics_;
  const ShardCounts& counts_;
  const std::vector<Generator>& generators_;
  const PolicyOptions& policy_;
  const GridPrecision& stored_;
  const std::vector<uint64_t>& weights_bytes_;
  int threads_;
  UnitCosts unit_;
  const LightGridBytes bytes_;  // of the file; counted once, since light is coded for it
  double coded_share_ = 1.0;    // of theta's bytes in a file over those of its numbers
  std::vector<Saving> savings_;
};

}  // namespace

std::vector<Saving> savingsOf(const Bake& bake, const std::vector<Generator>& generators, const PolicyOptions& policy,
                              const GridPrecision& stored, const std::vector<uint64_t>& weights_bytes, int threads) {
  return SavingsCount(bake, generators, policy, stored, weights_bytes, threads).run();
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

std::string toTable(const std::vector<Saving>& savings) {
  std::string text = fmt::format("{:<56} {:>12} {:>12} {:>9} {:>12}\n", "left out", "count", "of", "seconds", "bytes");
  for (const Saving& saving : savings) {
    text += fmt::format("{:<56} {:>12} {:>12} {:>9} {:>12}  {}\n", saving.what, saving.count, saving.of,
                        saving.seconds ? fmt::format("{:.3f}", *saving.seconds) : "-",
                        saving.bytes ? std::to_string(*saving.bytes) : "-", saving.note);
  }
  return text;
}

}  // namespace nlg
