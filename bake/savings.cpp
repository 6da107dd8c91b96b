#include "bake/savings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>

#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/light_form.h"
#include "runtime_eval/light_grid/light_grid_file.h"
#include "runtime_eval/light_grid/probe_tree_data.h"

namespace nlg {
namespace {

// Of a node without used cells in the file: its kind, and the mask of its children where some cells are none
// (docs/reference/formats.md).
int64_t nodeBytes(uint64_t child_mask) { return child_mask == 0 || child_mask == ~uint64_t{0} ? 1 : 1 + 8; }

constexpr int kTreeLevels = 3;

// What a function takes in the file: theta, and which representation it is of.
int64_t functionBytes(const Representation& representation, ThetaPrecision precision) {
  return static_cast<int64_t>(thetaForm(representation, precision).bytes()) + 1;
}

class SavingsCount {
 public:
  SavingsCount(const Bake& bake, const std::vector<Generator>& generators, const PolicyOptions& policy,
               const std::vector<uint64_t>& weights_bytes)
      : grid_(bake.grid),
        statistics_(bake.statistics),
        counts_(bake.statistics.counts),
        generators_(generators),
        policy_(policy),
        precision_(policy.theta_precision),
        chosen_(bake.statistics.chosen(generators.size())),
        weights_bytes_(weights_bytes) {}

  std::vector<Saving> run() {
    addProbes();
    addRepresentations();
    addFits();
    addNeverChosen();
    savings_.push_back(thetaBits());
    savings_.push_back({saving::kSolidRays,
                        false,
                        counts_.free_space,
                        counts_.grid_probes,
                        {},
                        0,
                        {},
                        "14 each, the only rays that they cast; neighbours with nothing between them could share one answer"});
    addTree();
    addAir();
    addLight();
    return std::move(savings_);
  }

 private:
  int64_t bytesOf(size_t function) const {
    return functionBytes(grid_.representations[grid_.function_representation[function]], precision_);
  }
  int64_t smallestBytes() const { return functionBytes(generators_.front().representation(), precision_); }

  void addProbes() {
    const uint64_t probes = counts_.grid_probes;
    const auto thetaEach = [this](uint64_t count) { return static_cast<int64_t>(count) * smallestBytes(); };
    savings_.push_back(
        {saving::kFreeSpace,
         true,
         counts_.free_space,
         probes,
         {},
         0,
         {},
         "no links and no function; the bare tent, exactly. Duplicates of one another: there would be one theta at most"});
    savings_.push_back(
        {saving::kInSolid,
         true,
         counts_.in_solid,
         probes,
         {},
         thetaEach(counts_.in_solid),
         {},
         "no links, function or theta; no weight. Counted bytes: a theta of the smallest representation each, at most"});
    savings_.push_back({saving::kEmpty,
                        true,
                        counts_.empty,
                        probes,
                        {},
                        thetaEach(counts_.empty),
                        {},
                        "no theta; their links and functions are made all the same, to know it. Counted bytes: as above"});
    int64_t shared = 0;
    std::vector<uint64_t> uses(grid_.functionCount(), 0);
    for (const uint32_t function : grid_.probe_function) {
      if (function < uses.size() && uses[function]++ > 0) shared += bytesOf(function);
    }
    savings_.push_back(
        {saving::kDuplicates, true, counts_.duplicates, probes, {}, shared, {}, "one theta for all that are alike"});
    const uint64_t tents = statistics_.bare_tents.count;
    savings_.push_back({saving::kBareTent,
                        true,
                        tents,
                        tents + counts_.duplicates + counts_.functions,
                        {},
                        thetaEach(tents),
                        {},
                        "bare_tent_rmse; no theta, and nothing to evaluate in the look-up. Counted bytes: as above"});
    const uint64_t all = counts_.free_space + counts_.in_solid + counts_.empty + counts_.duplicates + tents;
    const int64_t all_bytes = thetaEach(counts_.free_space + counts_.in_solid + counts_.empty + tents) + shared;
    savings_.push_back({saving::kAllProbes, true, all, probes, {}, all_bytes, {}, "a function and a theta for every probe"});
  }

  void addAir() {
    const AirStatistics& air = statistics_.air;
    savings_.push_back(
        {saving::kAirlessCells,
         air.airless_cells > 0 ? std::optional(true) : std::nullopt,
         air.airless_cells,
         air.cells,
         {},
         0,
         {},
         "air_only: no place in air was found in them; look-ups there take light from the nearest cell that has some"});
    const uint64_t unread = air.probes - counts_.grid_probes;
    savings_.push_back({saving::kUnreadProbes,
                        air.airless_cells > 0 ? std::optional(true) : std::nullopt,
                        unread,
                        air.probes,
                        {},
                        {},
                        {},
                        "no visibility, function, theta or light, and nothing of them in the file"});
  }

  void addLight() {
    const LightStatistics& light = statistics_.light;
    const uint64_t rays = light.places * light.rays_per_place;
    const bool traced = light.is_lit && !light.is_gathered;
    savings_.push_back({saving::kStoredBounces,
                        light.is_lit && light.is_gathered ? std::optional(true) : std::nullopt,
                        light.is_gathered ? rays : 0,
                        rays,
                        {},
                        0,
                        {},
                        light.is_gathered ? "one ray holds them all: its end shines with what the level's compiler left there"
                                          : "this scene holds no light of its own"});
    savings_.push_back(
        {saving::kSharedBounces,
         traced ? std::optional(light.cache_cells > 0) : std::nullopt,
         light.cache_cells - light.cache_divided,
         light.cache_cells,
         {},
         0,
         {},
         traced ? "light_cache: cells of surface, but for those that walls divide; paths end there" : "nothing was traced"});
    const auto full = static_cast<int64_t>(sizeof(float)) * kShFloats;
    const auto stored = static_cast<int64_t>(lightFormBytes(light.form));
    savings_.push_back({saving::kLightBits,
                        light.is_lit ? std::optional(stored < full) : std::nullopt,
                        light.is_lit ? counts_.grid_probes : 0,
                        counts_.grid_probes,
                        {},
                        light.is_lit ? static_cast<int64_t>(counts_.grid_probes) * (full - stored) : 0,
                        {},
                        std::string("light_form: ") + lightFormName(light.form) + ", against 27 floats a probe"});
  }

  void addRepresentations() {
    const uint64_t functions = counts_.functions,
                   enough = functions -
                            static_cast<uint64_t>(std::count(statistics_.larger_ran.begin(), statistics_.larger_ran.end(), 1));
    const std::string smallest = representationName(generators_.front().representation());
    const bool several = generators_.size() > 1;
    savings_.push_back({saving::kLargerGenerators,
                        several ? std::optional(true) : std::nullopt,
                        enough,
                        functions,
                        {},
                        several ? std::optional<int64_t>(0) : std::nullopt,
                        {},
                        several ? fmt::format("only the generator of {} ran for them", smallest)
                                : fmt::format("{} is the only representation of this bake", smallest)});
    if (several) {
      const Representation& largest = generators_.back().representation();
      int64_t bytes = 0;
      for (size_t f = 0; f < grid_.functionCount(); ++f) bytes += functionBytes(largest, precision_) - bytesOf(f);
      savings_.push_back({saving::kLargestTheta,
                          true,
                          functions - chosen_.back(),
                          functions,
                          {},
                          bytes,
                          {},
                          fmt::format("against {} alone, for every function", representationName(largest))});
    }
    int64_t tent_bytes = 0;
    uint64_t tents = 0;
    for (size_t f = 0; f < grid_.functionCount(); ++f) {
      if (statistics_.tent_passes[f]) ++tents, tent_bytes += bytesOf(f);
    }
    savings_.push_back({saving::kPassingTent,
                        false,
                        tents,
                        functions,
                        {},
                        tent_bytes,
                        {},
                        "bare_tent_rmse up to tau_rmse would leave them out, too"});
  }

  void addFits() {
    const auto good = static_cast<uint64_t>(
        std::count_if(statistics_.records.begin(), statistics_.records.end(), [this](const ThetaRecord& record) {
          const FunctionCheck& network = record.at(ThetaWord::network);
          return isGood(network, policy_.stages.good_rmse, policy_.check());
        }));
    savings_.push_back({saving::kGoodTheta,
                        true,
                        good,
                        counts_.functions,
                        {},
                        0,
                        {},
                        "good_rmse: thetas of the network, in the representation that was chosen"});
    savings_.push_back({saving::kRefinement,
                        true,
                        static_cast<uint64_t>(std::count_if(statistics_.records.begin(), statistics_.records.end(),
                                                            [this](const ThetaRecord& record) {
                                                              return !record.refined &&
                                                                     record.at(ThetaWord::fitted).passes(policy_.check());
                                                            })),
                        counts_.functions,
                        {},
                        0,
                        {},
                        "the check passes before"});
  }

  void addNeverChosen() {
    std::vector<std::string> names;
    uint64_t bytes = 0;
    for (size_t g = 0; g < generators_.size(); ++g) {
      if (chosen_[g] > 0) continue;
      names.emplace_back(representationName(generators_[g].representation()));
      bytes += weights_bytes_[g];
    }
    const std::string list = names.empty() ? "every one of them has a function" : fmt::format("{}", fmt::join(names, ", "));
    savings_.push_back({saving::kNeverChosen,
                        true,
                        names.size(),
                        generators_.size(),
                        {},
                        static_cast<int64_t>(bytes),
                        {},
                        list + "; not in the light grid, and left out of the scene's weights by nlg-export used-by"});
    if (!names.empty()) {
      savings_.push_back({saving::kNeverChosenGenerators,
                          false,
                          names.size(),
                          generators_.size(),
                          {},
                          0,
                          {},
                          "known only after a bake; the next one of the scene can do without their weights"});
    }
  }

  Saving thetaBits() const {
    const bool is_rounded = precision_ != ThetaPrecision::float32;
    const size_t stored = lightGridBytes(grid_, {is_rounded ? precision_ : ThetaPrecision::float16}).theta;
    const auto bytes = static_cast<int64_t>(grid_.theta.size() * sizeof(float) - stored);
    return {saving::kThetaBits,
            is_rounded,
            grid_.theta.size(),
            grid_.theta.size(),
            {},
            bytes,
            {},
            is_rounded ? std::string("theta_precision: ") + thetaPrecisionName(precision_)
                       : "theta_precision: float16 would leave them out"};
  }

  void addTree() {
    const ProbeTreeData tree = probeTreeData(grid_.tree);
    const std::vector<uint8_t> cell_log2 = probeTreeLists(grid_.tree).cell_log2;
    uint64_t roots = 0, empty_roots = 0;
    std::array<uint64_t, kTreeLevels> nodes{}, cells{};
    std::array<int64_t, kTreeLevels> bytes{};
    for (size_t n = 0; n < tree.cell_count.size(); ++n) {
      const bool holds_nothing = tree.child_mask[n] == 0 && tree.used_mask[n] == 0;
      const int side_log2 = cell_log2[n] + std::countr_zero(static_cast<uint32_t>(tree.cell_count[n]));
      const int level = holds_nothing ? 0 : (std::countr_zero(static_cast<uint32_t>(kRootSide)) - side_log2) / 2;
      roots += level == 0;
      empty_roots += holds_nothing;
      ++nodes[level];
      bytes[level] += nodeBytes(tree.child_mask[n]);
      cells[level] += static_cast<uint64_t>(std::popcount(tree.used_mask[n]));
    }
    uint64_t without = 0, leading = 0;
    int64_t leading_bytes = 0;
    for (int level = 0; level < kTreeLevels; ++level) {
      without += nodes[level] == 0;
      if (nodes[level] == 0 || cells[level] > 0) continue;
      ++leading;
      leading_bytes += bytes[level];
    }
    savings_.push_back(
        {saving::kLevels, true, without, kTreeLevels, {}, 0, {}, "look-ups end before them, files hold nothing of them"});
    savings_.push_back({saving::kThroughLevels,
                        false,
                        leading,
                        kTreeLevels,
                        {},
                        leading_bytes,
                        {},
                        fmt::format("nodes a level: {}; cells: {}", fmt::join(nodes, ", "), fmt::join(cells, ", "))});
    savings_.push_back({saving::kEmptyRoots,
                        false,
                        empty_roots,
                        roots,
                        {},
                        nodeBytes(0) * static_cast<int64_t>(empty_roots),
                        {},
                        "the look-up finds its root by its place in the array"});
  }

  const LightGrid& grid_;
  const BakeStatistics& statistics_;
  const ShardCounts& counts_;
  const std::vector<Generator>& generators_;
  const PolicyOptions& policy_;
  ThetaPrecision precision_;
  std::vector<uint64_t> chosen_;  // functions by representation
  const std::vector<uint64_t>& weights_bytes_;
  std::vector<Saving> savings_;
};

}  // namespace

std::vector<Saving> countSavings(const Bake& bake, const std::vector<Generator>& generators, const PolicyOptions& policy,
                                 const std::vector<uint64_t>& weights_bytes) {
  return SavingsCount(bake, generators, policy, weights_bytes).run();
}

Saving* findSaving(std::vector<Saving>& savings, const std::string& what) {
  const auto found = std::find_if(savings.begin(), savings.end(), [&](const Saving& saving) { return saving.what == what; });
  return found == savings.end() ? nullptr : &*found;
}

}  // namespace nlg
