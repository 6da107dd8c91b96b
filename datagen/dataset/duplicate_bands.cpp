#include "datagen/dataset/duplicate_bands.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "datagen/dataset/duplicate_index.h"
#include "datagen/dataset/nameless_file.h"
#include "datagen/dataset/packed_functions.h"
#include "datagen/dataset/shard_check.h"
#include "datagen/dataset/shard_reader.h"

namespace nlg {
namespace {

constexpr uint64_t kRowsAtOnce = 1024;
constexpr uint32_t kBinWidth = 256;       // of sums
constexpr uint32_t kMaxSum = 32 * 65535;  // of a sketch
constexpr size_t kBinCount = kMaxSum / kBinWidth + 1;

// What a function is searched by, and where its samples lie: as it lies in the temporary file.
struct Record {
  DuplicateIndex::Sketch sketch;
  uint64_t place;  // among the packed functions
};
static_assert(sizeof(Record) == 88);

// The sketches and samples of all functions, on the disk, and how many of them there are by sum.
class Sketches {
 public:
  Sketches(const std::vector<std::string>& shards, const std::string& folder)
      : file_(folder, "sketches of functions, for comparison") {
    std::vector<Record> block;
    for (const std::string& path : shards) {
      const ShardReader reader(path, 0, point_count_);
      if (!sketcher_) {
        rule_ = reader.header().duplicate_rule;
        point_count_ = reader.header().point_count;
        sketcher_.emplace(rule_, point_count_, nullptr);
        packed_.emplace(point_count_, folder);
      }
      requireSameRule(reader.header(), rule_);
      reader.verifyDigest();
      for (uint64_t first = 0; first < reader.functionCount(); first += kRowsAtOnce) {
        const Shard rows = reader.read(first, std::min(kRowsAtOnce, reader.functionCount() - first));
        block.clear();
        for (uint64_t n = 0; n < rows.functionCount(); ++n) {
          const StoredFunction function = functionAt(rows, n);
          block.push_back({sketcher_->sketch(function), packed_->append(function)});
          ++counts_[block.back().sketch.sum() / kBinWidth];
        }
        file_.append(block.data(), block.size() * sizeof(Record));
      }
    }
  }

  uint64_t count() const { return file_.byteCount() / sizeof(Record); }
  DuplicateIndex emptyIndex(DuplicateIndex::Fetch fetch) const { return {rule_, point_count_, std::move(fetch)}; }
  uint32_t sumReach() const { return sketcher_ ? sketcher_->sumReach() : 0; }
  int pointCount() const { return point_count_; }
  // Good until the next call.
  StoredFunction samples(uint64_t place) { return packed_->at(place); }

  // Ends of bands that hold at most `capacity` functions each; the last is beyond all sums.
  std::vector<uint32_t> bandEnds(uint64_t capacity) const {
    std::vector<uint32_t> ends;
    uint64_t in_band = 0;
    for (size_t bin = 0; bin < kBinCount; ++bin) {
      if (in_band > 0 && in_band + counts_[bin] > capacity) {
        ends.push_back(static_cast<uint32_t>(bin) * kBinWidth);
        in_band = 0;
      }
      in_band += counts_[bin];
    }
    ends.push_back(kMaxSum + 1);
    return ends;
  }

  // Calls visit(which one in the order of the shards, record) for every record whose sum is in [low, end).
  template <class Visit>
  void forEachBetween(uint32_t low, uint32_t end, const Visit& visit) const {
    std::vector<Record> block(16384);
    for (uint64_t first = 0; first < count(); first += block.size()) {
      block.resize(std::min<uint64_t>(block.size(), count() - first));
      file_.read(first * sizeof(Record), block.data(), block.size() * sizeof(Record));
      for (size_t i = 0; i < block.size(); ++i) {
        if (const uint32_t sum = block[i].sketch.sum(); sum >= low && sum < end) visit(first + i, block[i]);
      }
    }
  }

 private:
  NamelessFile file_;
  DuplicateRule rule_;
  int point_count_ = 0;
  std::optional<DuplicateIndex> sketcher_;
  std::optional<PackedFunctions> packed_;
  std::vector<uint64_t> counts_ = std::vector<uint64_t>(kBinCount, 0);
};

}  // namespace

std::vector<bool> findDuplicates(const std::vector<std::string>& shards, uint64_t memory_bytes, const std::string& folder) {
  Sketches sketches(shards, folder);
  std::vector<bool> is_duplicate(sketches.count(), false);
  std::vector<uint8_t> samples(static_cast<size_t>(sketches.pointCount()) / 8 * 9);
  uint32_t low = 0;
  for (const uint32_t end : sketches.bandEnds(memory_bytes / 2 / kDuplicateBytesAFunction)) {
    std::vector<uint64_t> places;  // of what the index holds, by id
    DuplicateIndex index = sketches.emptyIndex([&](uint64_t id) { return sketches.samples(places[id]); });
    sketches.forEachBetween(low - std::min(low, sketches.sumReach()), low, [&](uint64_t n, const Record& record) {
      if (is_duplicate[n]) return;
      index.add(record.sketch);
      places.push_back(record.place);
    });
    sketches.forEachBetween(low, end, [&](uint64_t n, const Record& record) {
      bool is_fetched = false;
      const auto fetch = [&] {
        // a copy: the function that it is compared with is fetched from the same place
        if (!std::exchange(is_fetched, true)) {
          const StoredFunction function = sketches.samples(record.place);
          std::copy_n(function.phi, sketches.pointCount(), samples.begin());
          std::copy_n(function.validity, sketches.pointCount() / 8, samples.begin() + sketches.pointCount());
        }
        return StoredFunction{samples.data(), samples.data() + sketches.pointCount()};
      };
      is_duplicate[n] = index.findOrAdd(record.sketch, fetch).has_value();
      if (!is_duplicate[n]) places.push_back(record.place);
    });
    low = end;
  }
  return is_duplicate;
}

}  // namespace nlg
