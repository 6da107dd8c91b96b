#include "bake/needs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>

#include "runtime_eval/light_grid/probe_tree_data.h"

namespace nlg {
namespace {

// Of a node in the file: the tensors node.… (docs/reference/formats.md).
constexpr int64_t kNodeBytes = 8 + 8 + 4 + 4 + 1 + 1;
constexpr int kTreeLevels = 3;

// What a function takes in the file: theta, and which representation it is of.
int64_t functionBytes(const Representation& representation, ThetaPrecision precision) {
  return int64_t{precision == ThetaPrecision::float16 ? 2 : 4} * representation.thetaCount() + 1;
}

class NeedsCount {
 public:
  NeedsCount(const Bake& bake, const std::vector<Generator>& generators, ThetaPrecision precision,
             const std::vector<uint64_t>& weights_bytes)
      : grid_(bake.grid),
        statistics_(bake.statistics),
        counts_(bake.statistics.counts),
        generators_(generators),
        precision_(precision),
        weights_bytes_(weights_bytes) {}

  std::vector<Need> run() {
    addProbes();
    addRepresentations();
    addFits();
    addNeverChosen();
    needs_.push_back(halfTheta());
    needs_.push_back({need::kSolidRays,
                      false,
                      counts_.free_space,
                      counts_.grid_probes,
                      {},
                      0,
                      {},
                      "14 each, the only rays that they cast; neighbours with nothing between them could share one answer"});
    addTree();
    needs_.push_back({need::kLighting, {}, 0, 0, {}, {}, {}, "the bake has no lighting yet: nothing ran that could be left out"});
    return std::move(needs_);
  }

 private:
  int64_t bytesOf(size_t function) const {
    return functionBytes(grid_.representations[grid_.function_representation[function]], precision_);
  }
  int64_t smallestBytes() const { return functionBytes(generators_.front().representation(), precision_); }

  void addProbes() {
    const uint64_t probes = counts_.grid_probes;
    const auto thetaEach = [this](uint64_t count) { return static_cast<int64_t>(count) * smallestBytes(); };
    needs_.push_back(
        {need::kFreeSpace,
         true,
         counts_.free_space,
         probes,
         {},
         0,
         {},
         "no links and no function; the bare tent, exactly. Duplicates of one another: there would be one theta at most"});
    needs_.push_back(
        {need::kInSolid,
         true,
         counts_.in_solid,
         probes,
         {},
         thetaEach(counts_.in_solid),
         {},
         "no links, function or theta; no weight. Counted bytes: a theta of the smallest representation each, at most"});
    needs_.push_back({need::kEmpty,
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
    needs_.push_back({need::kDuplicates, true, counts_.duplicates, probes, {}, shared, {}, "one theta for all that are alike"});
    const uint64_t tents = statistics_.bare_tents.count;
    needs_.push_back({need::kBareTent,
                      true,
                      tents,
                      tents + counts_.duplicates + counts_.functions,
                      {},
                      thetaEach(tents),
                      {},
                      "bare_tent_rmse; no theta, and nothing to evaluate in the look-up. Counted bytes: as above"});
    const uint64_t all = counts_.free_space + counts_.in_solid + counts_.empty + counts_.duplicates + tents;
    const int64_t all_bytes = thetaEach(counts_.free_space + counts_.in_solid + counts_.empty + tents) + shared;
    needs_.push_back({need::kAllProbes, true, all, probes, {}, all_bytes, {}, "a function and a theta for every probe"});
  }

  void addRepresentations() {
    const uint64_t functions = counts_.functions, enough = statistics_.smallest_enough;
    const std::string smallest = representationName(generators_.front().representation());
    const bool several = generators_.size() > 1;
    needs_.push_back({need::kLargerGenerators,
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
      needs_.push_back({need::kLargestTheta,
                        true,
                        functions - statistics_.chosen.back(),
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
    needs_.push_back({need::kPassingTent,
                      false,
                      tents,
                      functions,
                      {},
                      tent_bytes,
                      {},
                      "bare_tent_rmse up to tau_rmse would leave them out, too"});
  }

  void addFits() {
    const bool corrects = std::any_of(generators_.begin(), generators_.end(), [](const Generator& generator) {
      return generator.correctionStepCount() > 0 || generator.exactLastLayer();
    });
    needs_.push_back(
        {need::kCorrection,
         corrects ? std::optional(true) : std::nullopt,
         statistics_.right,
         statistics_.checked,
         {},
         corrects ? std::optional<int64_t>(0) : std::nullopt,
         {},
         corrects ? "predicted thetas whose error is low enough, of all representations" : "the weights hold no corrections"});
    needs_.push_back({need::kRefinement,
                      true,
                      counts_.functions - statistics_.failed_check,
                      counts_.functions,
                      {},
                      0,
                      {},
                      "the check passes before; against one round for each of them"});
  }

  void addNeverChosen() {
    std::vector<std::string> names;
    uint64_t bytes = 0;
    for (size_t g = 0; g < generators_.size(); ++g) {
      if (statistics_.chosen[g] > 0) continue;
      names.emplace_back(representationName(generators_[g].representation()));
      bytes += weights_bytes_[g];
    }
    const std::string list = names.empty() ? "every one of them has a function" : fmt::format("{}", fmt::join(names, ", "));
    needs_.push_back({need::kNeverChosen,
                      true,
                      names.size(),
                      generators_.size(),
                      {},
                      static_cast<int64_t>(bytes),
                      {},
                      list + "; not in the light grid, and left out of the scene's weights by nlg-export for-bake"});
    if (!names.empty()) {
      needs_.push_back({need::kNeverChosenGenerators,
                        false,
                        names.size(),
                        generators_.size(),
                        {},
                        0,
                        {},
                        "known only after a bake; the next one of the scene can do without their weights"});
    }
  }

  Need halfTheta() const {
    const bool is_half = precision_ == ThetaPrecision::float16;
    const auto bytes = static_cast<int64_t>(grid_.theta.size()) * 2;
    return {need::kHalfTheta,
            is_half,
            grid_.theta.size(),
            grid_.theta.size(),
            {},
            bytes,
            {},
            is_half ? "theta_precision: float16" : "theta_precision: float16 would leave them out"};
  }

  void addTree() {
    const ProbeTreeData tree = probeTreeData(grid_.tree);
    uint64_t roots = 0, empty_roots = 0;
    std::array<uint64_t, kTreeLevels> nodes{}, cells{};
    for (size_t n = 0; n < tree.cell_count.size(); ++n) {
      const bool holds_nothing = tree.child_mask[n] == 0 && tree.used_mask[n] == 0;
      const int side_log2 = tree.cell_log2[n] + std::countr_zero(static_cast<uint32_t>(tree.cell_count[n]));
      const int level = holds_nothing ? 0 : (std::countr_zero(static_cast<uint32_t>(kRootSide)) - side_log2) / 2;
      roots += level == 0;
      empty_roots += holds_nothing;
      ++nodes[level];
      cells[level] += static_cast<uint64_t>(std::popcount(tree.used_mask[n]));
    }
    uint64_t without = 0, leading = 0;
    int64_t leading_bytes = 0;
    for (int level = 0; level < kTreeLevels; ++level) {
      without += nodes[level] == 0;
      if (nodes[level] == 0 || cells[level] > 0) continue;
      ++leading;
      leading_bytes += kNodeBytes * static_cast<int64_t>(nodes[level]);
    }
    needs_.push_back(
        {need::kLevels, true, without, kTreeLevels, {}, 0, {}, "look-ups end before them, files hold nothing of them"});
    needs_.push_back({need::kThroughLevels,
                      false,
                      leading,
                      kTreeLevels,
                      {},
                      leading_bytes,
                      {},
                      fmt::format("nodes a level: {}; cells: {}", fmt::join(nodes, ", "), fmt::join(cells, ", "))});
    needs_.push_back({need::kEmptyRoots,
                      false,
                      empty_roots,
                      roots,
                      {},
                      kNodeBytes * static_cast<int64_t>(empty_roots),
                      {},
                      "the look-up finds its root by its place in the array"});
  }

  const LightGrid& grid_;
  const BakeStatistics& statistics_;
  const ShardCounts& counts_;
  const std::vector<Generator>& generators_;
  ThetaPrecision precision_;
  const std::vector<uint64_t>& weights_bytes_;
  std::vector<Need> needs_;
};

}  // namespace

std::vector<Need> countNeeds(const Bake& bake, const std::vector<Generator>& generators, ThetaPrecision theta_precision,
                             const std::vector<uint64_t>& weights_bytes) {
  return NeedsCount(bake, generators, theta_precision, weights_bytes).run();
}

Need* findNeed(std::vector<Need>& needs, const std::string& what) {
  const auto found = std::find_if(needs.begin(), needs.end(), [&](const Need& need) { return need.what == what; });
  return found == needs.end() ? nullptr : &*found;
}

}  // namespace nlg
