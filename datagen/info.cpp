#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datagen/commands.h"
#include "datagen/dataset/function_set.h"
#include "datagen/dataset/shard_file.h"
#include "nlg/policy.h"
#include "runtime_eval/support/weighting_function.h"
#include "tool/atomic_file.h"
#include "tool/command/file_info.h"
#include "tool/error.h"
#include "tool/printable.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kPieceFunctions = 1024;  // about 10 MB at a time

// What only a look at all functions tells.
struct Statistics {
  uint64_t open_shell = 0, few_seen = 0, in_solid = 0;
  float spacing_min_m = std::numeric_limits<float>::infinity(), spacing_max_m = 0.0f;
};

void requireCountsThatAddUp(const ShardHeader& header) {
  const ShardCounts& c = header.counts;
  const uint64_t sum = c.functions + c.free_space + c.in_solid + c.duplicates + c.empty + c.outside;
  if (sum == c.visited_probes && c.visited_probes <= c.grid_probes) return;
  throw InputError(header.path, "attribute count_visited_probes",
                   fmt::format("{}, what the probes' outcomes add up to, of {} probes", sum, c.grid_probes),
                   std::to_string(c.visited_probes));
}

void addTo(const FunctionRows& piece, Statistics& statistics) {
  for (const uint8_t flags : piece.flags) {
    statistics.open_shell += (flags & kFlagOpenShell) != 0;
    statistics.few_seen += (flags & kFlagFewSeen) != 0;
    statistics.in_solid += (flags & kFlagInSolid) != 0;
  }
  for (const float spacing_m : piece.spacing_m) {
    statistics.spacing_min_m = std::min(statistics.spacing_min_m, spacing_m);
    statistics.spacing_max_m = std::max(statistics.spacing_max_m, spacing_m);
  }
}

Statistics verify(const ShardReader& reader) {
  requireCountsThatAddUp(reader.header());
  reader.verifyDigest();
  Statistics statistics;
  DuplicateFilter filter;
  for (uint64_t first = 0; first < reader.functionCount(); first += kPieceFunctions) {
    Shard piece = reader.read(first, std::min(kPieceFunctions, reader.functionCount() - first));
    addTo(piece, statistics);
    const uint64_t count = piece.functionCount();
    filter.removeKnown(&piece);
    if (piece.functionCount() == count) continue;
    throw InputError(reader.header().path, fmt::format("functions {} to {}", first, first + count - 1),
                     "no duplicates within or before them", fmt::format("{} duplicates", count - piece.functionCount()));
  }
  return statistics;
}

Json shardJson(const ShardReader& reader, const Statistics& statistics) {
  const Shard& s = reader.header();
  const ShardCounts& c = s.counts;
  const double functions = static_cast<double>(std::max<uint64_t>(c.functions, 1));
  // what the shard is of, then what became of its probes
  Json json = {{"schema_version", kShardVersion}, {"scene", s.scene_id}, {"family", s.family}, {"jitter", s.jitter}};
  json.update(countsJson(c));
  json.update({{"duplicate_rms", s.duplicate_rule.rms},
               {"duplicate_validity_points", s.duplicate_rule.validity_points},
               {"flagged_open_shell", statistics.open_shell},
               {"flagged_few_seen", statistics.few_seen},
               {"flagged_in_solid", statistics.in_solid},
               {"spacing_min_m", c.functions > 0 ? statistics.spacing_min_m : 0.0f},
               {"spacing_max_m", statistics.spacing_max_m},
               {"points", s.point_count},
               {"test_points", s.test_point_count},
               {"pattern_hash", fmt::format("{:016x}", s.pattern_hash)},
               {"test_pattern_hash", fmt::format("{:016x}", s.test_pattern_hash)},
               {"bytes_per_function", static_cast<double>(std::filesystem::file_size(s.path)) / functions},
               {"verified", kVerifiedByDigest},
               {"origin", parsedOrText(s.provenance_json)}});
  return json;
}

// Whether a file that was refused is proven damaged: throws DamageError when its bytes break HDF5's own structure, a checksum or the
// digest, and returns when they do not (a sound file of another kind, version or pattern).
// throws   InputError with the system's reason when the system does not give every byte: that proves nothing
void refuseDamage(const std::string& path) {
  fileSha256(path);
  try {
    Hdf5Reader(path).verifyDigest();
  } catch (const DamageError&) {
    throw;
  } catch (const InputError&) {
    // no digest: a stranger's file
  }
}

constexpr double kHardRmse = 0.01;  // as nlg-validate's hard_tent_rmse
// Upper ends of the bins of the bare tent's blend RMSE; the first one is what a bake stores as a bare tent.
constexpr std::array kBins = {0.002, 0.005, 0.01, 0.02, 0.04, 0.08, 1e9};

struct Row {
  ShardCounts counts;
  uint64_t bare_tents = 0, hard = 0, of_solid = 0, valid_points = 0, dark_points = 0;
  std::array<uint64_t, kBins.size()> bins{};

  void add(const Row& other) {
    addCounts(other.counts, &counts);
    for (uint64_t Row::*count : {&Row::bare_tents, &Row::hard, &Row::of_solid, &Row::valid_points, &Row::dark_points})
      this->*count += other.*count;
    for (size_t b = 0; b < bins.size(); ++b) bins[b] += other.bins[b];
  }
};

void addFunction(const StoredFunction& function, uint8_t flags, FunctionChecker& checker, Row* row) {
  static const PolicyOptions options;
  const FunctionCheck tent = checker.checkBareTent(function, options.check());
  row->bare_tents += takesBareTent(tent, options) ? 1 : 0;
  row->hard += tent.rmse >= kHardRmse ? 1 : 0;
  row->of_solid += (flags & kFlagInSolid) != 0 ? 1 : 0;
  ++row->bins[static_cast<size_t>(std::lower_bound(kBins.begin(), kBins.end() - 1, tent.blend_rmse) - kBins.begin())];
  row->valid_points += static_cast<uint64_t>(tent.valid_count);
  for (int p = 0; p < kSupportPointCount; ++p)
    row->dark_points += function.phi[p] == 0 && (function.validity[p / 8] >> p % 8 & 1) != 0 ? 1 : 0;
}

Row rowOf(const ShardReader& reader) {
  Row row;
  row.counts = reader.header().counts;
  FunctionChecker checker;
  for (uint64_t first = 0; first < reader.functionCount(); first += kPieceFunctions) {
    const Shard piece = reader.read(first, std::min(kPieceFunctions, reader.functionCount() - first));
    for (uint64_t i = 0; i < piece.functionCount(); ++i) addFunction(storedFunction(piece, i), piece.flags[i], checker, &row);
  }
  return row;
}

Json jsonOf(const Row& row) {
  const auto share = [](uint64_t part, uint64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  Json bins = Json::array();
  for (size_t b = 0; b < kBins.size(); ++b)
    bins.push_back({{"at_most", b + 1 < kBins.size() ? Json(kBins[b]) : Json()}, {"functions", row.bins[b]}});
  const ShardCounts& c = row.counts;
  return {{"probes", c.visited_probes},
          {"functions", c.functions},
          {"free_space", c.free_space},
          {"in_solid", c.in_solid},
          {"duplicates", c.duplicates},
          {"empty", c.empty},
          {"outside", c.outside},
          {"bare_tents", row.bare_tents},
          {"hard", row.hard},
          {"of_solid", row.of_solid},
          {"dark_share", share(row.dark_points, row.valid_points)},
          {"tent_blend_rmse", bins}};
}

std::string lineOf(const std::string& split, const std::string& scene, const Json& row) {
  const double functions = std::max(1.0, row["functions"].get<double>());
  const auto percent = [&](const char* key) { return 100.0 * row[key].get<double>() / functions; };
  return fmt::format("{:<11}{:<26}{:>8}{:>10}{:>10}{:>9}{:>11}{:>6}{:>9}{:>9.0f} %{:>5.0f} %{:>8.0f} %{:>5.0f} %\n",
                     printable(split), printable(scene).substr(0, 25), row["probes"].get<uint64_t>(),
                     row["functions"].get<uint64_t>(), row["free_space"].get<uint64_t>(), row["in_solid"].get<uint64_t>(),
                     row["duplicates"].get<uint64_t>(), row["empty"].get<uint64_t>(), row["outside"].get<uint64_t>(),
                     percent("bare_tents"), percent("hard"), percent("of_solid"), 100.0 * row["dark_share"].get<double>());
}

}  // namespace

Json describeShard(const std::string& path) {
  try {
    const ShardReader reader(path);
    return shardJson(reader, verify(reader));
  } catch (const InputError&) {
    refuseDamage(path);
    throw;
  }
}

Json dataCard(const std::string& folder, std::vector<std::string> shards) {
  if (shards.empty()) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      if (entry.path().extension() == ".h5" && entry.is_regular_file()) shards.push_back(entry.path().string());
  }
  if (shards.empty()) throw InputError(folder, "files", "shards (.h5) in it or below", "none");
  std::map<std::pair<std::string, std::string>, Row> rows;  // by split and scene
  for (const std::string& path : shards) {
    const ShardReader reader(path, supportPattern().hash, kSupportPointCount);
    rows[{std::filesystem::path(path).parent_path().filename().string(), reader.header().scene_id}].add(rowOf(reader));
  }
  Row all;
  Json scenes = Json::array();
  for (const auto& [name, row] : rows) {
    all.add(row);
    Json scene = {{"split", name.first}, {"scene", name.second}};
    scene.update(jsonOf(row));
    scenes.push_back(std::move(scene));
  }
  return {{"folder", folder}, {"shards", shards.size()}, {"scenes", std::move(scenes)}, {"all", jsonOf(all)}};
}

std::string dataCardText(const Json& card) {
  std::string text = fmt::format(
      "{}: {} "
      "shards\n\n{:>37}{:>8}{:>10}{:>45}{:>32}\n{:<11}{:<26}{:>8}{:>10}{:>10}{:>9}{:>11}{:>6}{:>9}{:>11}{:>7}{:>10}{:>7}\n",
      printable(card["folder"].get<std::string>()), card["shards"].get<uint64_t>(), "", "", "",
      "probes left out, because:", "of the functions:", "split", "scene", "probes", "functions", "open air", "solid", "duplicate",
      "dark", "outside", "bare tent", "hard", "of solid", "dark");
  for (const Json& row : card["scenes"]) text += lineOf(row["split"], row["scene"], row);
  const Json& all = card["all"];
  text += lineOf("all", "", all);
  text +=
      "\nopen air: no triangle near; solid: the probe is in solid; duplicate: as another function of the shard; dark: 0 "
      "everywhere; outside: nothing of the support lies within the level's hull (--keep-outside).\n"
      "bare tent: it is enough, and a bake stores nothing; hard: its RMSE is .01 or more; of solid: of probes in solid, seen "
      "from air; dark: "
      "points with 0.\n";
  return text;
}

}  // namespace nlg
