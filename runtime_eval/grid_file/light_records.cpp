#include "runtime_eval/grid_file/light_records.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <string>
#include <unordered_map>

#include "runtime_eval/numbers/range_coder.h"
#include "runtime_eval/probe_tree/morton.h"

namespace nlg {
namespace {

// What neighbours say of a number.
struct Expected {
  int number = 0;
  size_t doubt = 0;  // < kDoubts
};

constexpr size_t kDoubts = 8;

// Numbers of all records of a group, and what is expected of the next one. Both directions go the same way.
class RecordContext {
 public:
  RecordContext(const std::vector<RecordsBefore>& before, const std::vector<LightField>& fields)
      : before_(before), fields_(fields), numbers_(before.size() * fields.size()), is_dark_(before.size()), dark_(3) {
    for (std::vector<DifferenceModel>* models : {&by_neighbours_, &by_record_}) models->resize(kDoubts * fields.size());
  }

  void beginGroup() { last_lit_ = kNoRecord; }

  void beginRecord(size_t record) {
    record_ = record;
    near_count_ = 0;
    size_t near_dark = 0, near = 0;
    for (const uint32_t other : before_[record]) {
      if (other == kNoRecord) continue;
      ++near;
      if (is_dark_[other] != 0) {
        ++near_dark;
      } else {
        near_[near_count_++] = other;
      }
    }
    // how likely darkness is, by the neighbours that are dark
    darkness_ = near_dark == 0 ? 0 : near_dark < near ? 1 : 2;
    // without a lit neighbour the last lit record is the best guess
    if (near_count_ == 0 && last_lit_ != kNoRecord) near_[near_count_++] = last_lit_;
    mean_difference_ = 0;
  }

  BitModel* dark() { return &dark_[darkness_]; }
  void setDark(bool is_dark) {
    is_dark_[record_] = is_dark ? 1 : 0;
    if (!is_dark) last_lit_ = static_cast<uint32_t>(record_);
  }

  Expected expected(size_t field) const {
    std::array<int, 3> values{};
    for (size_t n = 0; n < near_count_; ++n) values[n] = numbers_[near_[n] * fields_.size() + field];
    // the median of three, the mean of two: their spread says how far they are trusted
    if (near_count_ == 0) return {1 << fields_[field].bits >> 1, kDoubts - 1};
    if (near_count_ == 1) return {values[0], kDoubts - 1};
    const auto doubtOf = [](int spread) {
      return std::min<size_t>(static_cast<size_t>(std::bit_width(static_cast<uint32_t>(spread))), kDoubts - 2);
    };
    if (near_count_ == 2) return {(values[0] + values[1] + 1) / 2, doubtOf(std::abs(values[0] - values[1]))};
    std::sort(values.begin(), values.end());
    return {values[1], doubtOf(values[2] - values[0])};
  }

  DifferenceModel* byNeighbours(size_t field, const Expected& expected) {
    return &by_neighbours_[expected.doubt * fields_.size() + field];
  }
  DifferenceModel* byRecord(size_t field) {
    const auto width = static_cast<size_t>(std::bit_width(static_cast<uint32_t>(mean_difference_)));
    return &by_record_[std::min(width, kDoubts - 1) * fields_.size() + field];
  }

  void set(size_t field, int number, int difference) {
    numbers_[record_ * fields_.size() + field] = static_cast<uint16_t>(number);
    mean_difference_ = field == 0 ? std::abs(difference) : (mean_difference_ + std::abs(difference) + 1) / 2;
  }

 private:
  const std::vector<RecordsBefore>& before_;
  const std::vector<LightField>& fields_;
  std::vector<uint16_t> numbers_;  // by record and field
  std::vector<uint8_t> is_dark_;   // by record
  uint32_t last_lit_ = kNoRecord;
  // of the record at hand
  size_t record_ = 0, near_count_ = 0, darkness_ = 0;
  std::array<uint32_t, 3> near_{};
  int mean_difference_ = 0;

  std::vector<BitModel> dark_;
  std::vector<DifferenceModel> by_neighbours_, by_record_;
};

}  // namespace

std::vector<RecordsBefore> recordsBefore(const ProbeTree& tree, const std::vector<uint32_t>& probe_function) {
  std::unordered_map<uint64_t, uint32_t> record_at;
  record_at.reserve(probe_function.size());
  std::vector<RecordsBefore> before;
  for (size_t probe = 0; probe < probe_function.size(); ++probe) {
    if (probe_function[probe] == kNoWeight) continue;
    const LatticePoint at = tree.probeLattice(probe);
    RecordsBefore& near = before.emplace_back();
    near.fill(kNoRecord);
    // a lower neighbour has a lower Morton key, so that its record is known by now
    for (size_t axis = 0; axis < 3; ++axis) {
      for (int32_t units = 1; units <= 4 && near[axis] == kNoRecord; units *= 2) {
        if (at[axis] < units) break;
        LatticePoint other = at;
        other[axis] -= units;
        if (const auto found = record_at.find(mortonFromLattice(other)); found != record_at.end()) near[axis] = found->second;
      }
    }
    record_at.emplace(mortonFromLattice(at), static_cast<uint32_t>(before.size() - 1));
  }
  return before;
}

std::vector<uint8_t> codedRecords(const PackedLight& packed, const std::vector<RecordsBefore>& before) {
  const std::vector<LightField> fields = lightFields(packed);
  const auto words = static_cast<size_t>(lightWords(packed));
  if (words == 0) return {};
  RecordContext context(before, fields);
  RangeEncoder encoder;
  for (size_t i = 0; i < packed.records.size() / words; ++i) {
    const uint32_t* record = &packed.records[i * words];
    // what neighbours say is of the same group
    if (i % before.size() == 0) context.beginGroup();
    context.beginRecord(i % before.size());
    const bool is_dark = lightNumber(record, fields[0]) == 0;
    encoder.add(is_dark ? 1 : 0, context.dark());
    context.setDark(is_dark);
    // a dark record is one bit
    for (size_t f = 0; f < fields.size() && !is_dark; ++f) {
      if (fields[f].bits == 0) continue;
      const auto number = static_cast<int>(lightNumber(record, fields[f]));
      const Expected expected = context.expected(f);
      encoder.add(number - expected.number, context.byNeighbours(f, expected), context.byRecord(f));
      context.set(f, number, number - expected.number);
    }
  }
  return encoder.finish();
}

FileResult decodeRecords(const std::vector<uint8_t>& bytes, const std::vector<RecordsBefore>& before, size_t group_count,
                         PackedLight* packed) {
  packed->records.clear();
  FileResult result = checkLightLayout(*packed);
  if (!result.ok()) return result;
  const std::vector<LightField> fields = lightFields(*packed);
  const auto words = static_cast<size_t>(lightWords(*packed));
  const FileResult others = {FileStatus::tensor_unexpected,
                             "light.records: not the records of " + std::to_string(before.size() * group_count) + " probes"};
  if (words == 0) return bytes.empty() ? FileResult{} : others;
  RecordContext context(before, fields);
  RangeDecoder decoder(bytes.data(), bytes.size());
  std::vector<uint32_t> records(before.size() * group_count * words);
  // the encoder's way, so that both expect the same numbers
  for (size_t i = 0; i < before.size() * group_count; ++i) {
    uint32_t* record = &records[i * words];
    if (i % before.size() == 0) context.beginGroup();
    context.beginRecord(i % before.size());
    const bool is_dark = decoder.next(context.dark()) == 1;
    context.setDark(is_dark);
    for (size_t f = 0; f < fields.size() && !is_dark; ++f) {
      if (fields[f].bits == 0) continue;
      const Expected expected = context.expected(f);
      const int difference = decoder.next(context.byNeighbours(f, expected), context.byRecord(f));
      const int number = expected.number + difference;
      // a scale of 0 is a dark record's
      if (number < (f == 0 ? 1 : 0) || number >= 1 << fields[f].bits) return others;
      record[fields[f].word] |= static_cast<uint32_t>(number) << fields[f].shift;
      context.set(f, number, difference);
    }
  }
  if (!decoder.isAtEnd()) return others;
  packed->records = std::move(records);
  return {};
}

}  // namespace nlg
