#include "datagen/dataset/shard_check.h"

#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "datagen/dataset/function_set.h"
#include "datagen/functions/nameless_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint64_t kMaxPointCount = 65536;

// For every byte of eight validity bits: eight bytes, 0xff where the bit is 0.
std::array<uint64_t, 256> makeInvalidMasks() {
  std::array<uint64_t, 256> masks{};
  for (size_t bits = 0; bits < masks.size(); ++bits) {
    std::array<uint8_t, 8> bytes{};
    for (size_t b = 0; b < 8; ++b) bytes[b] = (bits >> b & 1) != 0 ? 0 : 0xff;
    std::memcpy(&masks[bits], bytes.data(), 8);
  }
  return masks;
}

// phi of a point in solid is 0: every user may sum over all points without looking at validity.
Fault hiddenValueFault(const std::string& name, const std::vector<uint8_t>& phi, const std::vector<uint8_t>& validity,
                       uint64_t columns, uint64_t first_function) {
  static const std::array<uint64_t, 256> invalid_masks = makeInvalidMasks();
  for (size_t byte = 0; byte < validity.size(); ++byte) {
    uint64_t samples = 0;
    std::memcpy(&samples, &phi[8 * byte], 8);
    if ((samples & invalid_masks[validity[byte]]) == 0) continue;
    size_t i = 8 * byte;
    while (phi[i] == 0 || (validity[byte] >> i % 8 & 1) != 0) ++i;
    return {fmt::format("dataset {}: function {}, point {}", name, first_function + i / columns, i % columns),
            "0 at an invalid point", std::to_string(phi[i])};
  }
  return {};
}

Fault placementFault(const FunctionRows& rows, uint64_t first_function) {
  for (size_t i = 0; i < rows.spacing_m.size(); ++i) {
    const float spacing_m = rows.spacing_m[i];
    if (std::isfinite(spacing_m) && spacing_m > 0) continue;
    return {fmt::format("dataset spacing_m: function {}", first_function + i), "a finite number above 0",
            fmt::format("{}", spacing_m)};
  }
  for (size_t i = 0; i < rows.probe_position_m.size(); ++i) {
    if (std::isfinite(rows.probe_position_m[i])) continue;
    return {fmt::format("dataset probe_position_m: function {}", first_function + i / 3), "finite numbers",
            fmt::format("{}", rows.probe_position_m[i])};
  }
  return {};
}

// throws   InputError naming the shard when its functions are told apart by another rule than those of the first shard
void requireSameRule(const ShardHeader& shard, const DuplicateRule& first) {
  if (shard.duplicate_rule == first) return;
  const auto text = [](const DuplicateRule& rule) { return fmt::format("{:f} and {}", rule.rms, rule.validity_points); };
  throw InputError(shard.path, "attributes duplicate_rms and duplicate_validity_points", text(first) + " as in the first shard",
                   text(shard.duplicate_rule));
}

}  // namespace

double functionsPerProbe(const ShardCounts& counts) {
  if (counts.visited_probes == 0) return 0.0;
  return static_cast<double>(counts.functions + (counts.free_space > 0 ? 1 : 0)) / static_cast<double>(counts.visited_probes);
}

std::vector<uint64_t> withRows(uint64_t rows, std::vector<uint64_t> columns) {
  columns.insert(columns.begin(), rows);
  return columns;
}

Fault pointCountFault(uint64_t point_count, uint64_t test_point_count) {
  const std::string expected = fmt::format("a multiple of 8, at most {}", kMaxPointCount);
  if (point_count == 0 || point_count > kMaxPointCount || point_count % 8 != 0) {
    return {"attribute point_count", expected + ", not 0", std::to_string(point_count)};
  }
  if (test_point_count > kMaxPointCount || test_point_count % 8 != 0) {
    return {"attribute test_point_count", expected, std::to_string(test_point_count)};
  }
  return {};
}

Fault duplicateRuleFault(const DuplicateRule& rule) {
  if (std::isfinite(rule.rms) && rule.rms >= 0.0 && rule.rms <= 255.0) return {};
  return {"attribute duplicate_rms", "a number from 0 to 255", fmt::format("{}", rule.rms)};
}

Fault valueFault(const FunctionRows& rows, uint64_t first_function) {
  Fault fault = placementFault(rows, first_function);
  if (!fault.place.empty()) return fault;
  fault = hiddenValueFault("phi", rows.phi, rows.validity, static_cast<uint64_t>(rows.point_count), first_function);
  if (!fault.place.empty()) return fault;
  return hiddenValueFault("phi_test", rows.phi_test, rows.validity_test, static_cast<uint64_t>(rows.test_point_count),
                          first_function);
}

void DuplicateFilter::begin(const Shard& rows) {
  if (!index_) {
    rule_ = rows.duplicate_rule;
    index_.emplace(rule_, rows.point_count, [this](uint64_t id) { return samples(id); });
    if (!earlier_) packed_.emplace(rows.point_count, temporaryFolder());
  }
  requireSameRule(rows, rule_);
  current_ = &rows;
  first_of_current_ = index_->functionCount();
}

StoredFunction DuplicateFilter::samples(uint64_t id) {
  // those of the rows at work have moved to the front of their arrays
  if (id >= first_of_current_) return functionAt(*current_, id - first_of_current_);
  return earlier_ ? earlier_(id) : packed_->at(places_[id]);
}

bool DuplicateFilter::isDuplicate(const StoredFunction& function) {
  if (index_->findOrAdd(function)) return true;
  if (packed_) places_.push_back(packed_->append(function));
  return false;
}

void DuplicateFilter::removeKnown(Shard* rows) {
  begin(*rows);
  const uint64_t count = rows->functionCount();
  uint64_t kept = 0;
  for (uint64_t n = 0; n < count; ++n) {
    if (isDuplicate(functionAt(*rows, n))) continue;
    if (n != kept) moveRow(n, kept, rows);
    ++kept;
  }
  truncateRows(kept, rows);
  rows->counts.functions -= count - kept;
  rows->counts.duplicates += count - kept;
  current_ = nullptr;
}

}  // namespace nlg
