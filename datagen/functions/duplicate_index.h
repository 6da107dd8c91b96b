// Finds, among many functions, one that a new function duplicates.
//
// Exact: what it says follows from the samples themselves, and it misses nothing. Of any two functions that were both added,
// neither is a duplicate of the other, and every function that was refused has its match among those that were added. The search
// looks only at functions whose counts of valid points, octant by octant, and whose sums over groups of points are near enough,
// and that can be no reason to miss one: the rule itself, the triangle and the Cauchy-Schwarz inequality bound how far those of
// duplicates may lie apart (docs/reference/formats.md, "Duplicates").
//
// Memory: at most about 160 bytes a function; the samples themselves stay wherever the caller keeps them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "nlg/support.h"

namespace nlg {

// When two weighting functions count as one.
//
// Two functions are duplicates when their validity differs in at most validity_points points and
//   sum over all P points of (difference of phi)^2  <=  rms^2 * (points valid in both):
// the RMSE that one makes in place of the other, over the points valid in both, where a point valid in only one of them adds
// its whole value. Zeros: the same bytes.
struct DuplicateRule {
  double rms = 0.0;              // in steps of the stored samples, 1/255; >= 0
  uint64_t validity_points = 0;  // >= 0

  friend bool operator==(const DuplicateRule&, const DuplicateRule&) = default;
};

// The RMS difference of two duplicates, in 1/255; nothing when they are none. Symmetric, and the same on every machine.
// point_count   P, a multiple of 8
std::optional<double> duplicateDistance(const DuplicateRule& rule, const StoredFunction& a, const StoredFunction& b,
                                        int point_count);

class DuplicateIndex {
 public:
  // Gives the samples of the id-th function that was added; they need to last until the next call.
  using Fetch = std::function<StoredFunction(uint64_t id)>;
  struct Match {
    uint64_t id;            // of the function that is there already
    double rms_difference;  // in 1/255
  };

  // point_count   P, a multiple of 8, at most 65536
  DuplicateIndex(const DuplicateRule& rule, int point_count, Fetch fetch);

  // The match of a function, if there is one. Otherwise adds it, with the number of functions added before as its id: the caller
  // keeps its samples for fetch.
  std::optional<Match> findOrAdd(const StoredFunction& function);

  // Adds a function whatever it duplicates; its id is the number of functions added before.
  void add(const StoredFunction& function) { add(sketch(function)); }

  // Calls visit for every added function with isWanted(id) that this one duplicates; perhaps twice for one of them.
  void forEachMatch(const StoredFunction& function, const std::function<bool(uint64_t id)>& isWanted,
                    const std::function<void(const Match&)>& visit);

  uint64_t functionCount() const { return function_count_; }
  uint64_t comparedCount() const { return compared_count_; }  // calls of fetch so far

 private:
  static constexpr int kGroupCount = 32, kOctantCount = 8;
  // What a function is searched by, without its samples.
  struct Sketch {
    std::array<uint16_t, kOctantCount> valid_counts;
    std::array<uint16_t, kGroupCount> group_sums;
  };
  struct Entry : Sketch {
    uint32_t id;
  };
  // What cells are made of: valid points in all and by octant, and the sum over all groups.
  static constexpr int kFeatureCount = kOctantCount + 2;
  using Features = std::array<int64_t, kFeatureCount>;

  void add(const Sketch& sketch);
  Sketch sketch(const StoredFunction& function) const;
  static Features features(const Sketch& sketch);
  bool mayMatch(const Sketch& a, const Sketch& b) const;
  // Calls visit(other entry) for what may match, the function's own cell first (most matches lie there), until visit returns true.
  template <class Visit>
  void forEachNear(const Sketch& sketch, const Visit& visit) const;
  std::optional<Match> compare(const StoredFunction& function, uint64_t id);

  DuplicateRule rule_;
  int point_count_;
  Fetch fetch_;
  Features reach_, cell_width_;    // how far the features of duplicates lie apart at most, and the sides of a cell
  uint64_t max_squared_distance_;  // of the group sums of duplicates
  uint64_t function_count_ = 0, compared_count_ = 0;
  std::unordered_map<uint64_t, std::vector<Entry>> cells_;
};

}  // namespace nlg
