#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "datagen/dataset/function_set.h"
#include "datagen/dataset/shard_fields.h"
#include "datagen/dataset/shard_reader.h"
#include "tool/error.h"

namespace nlg {
namespace {

// Moves row `from` of an N x width array to row `to`.
template <class T>
void moveRow(std::vector<T>& rows, size_t width, uint64_t from, uint64_t to) {
  std::copy_n(rows.begin() + from * width, width, rows.begin() + to * width);
}

// Samples of functions in files, decoded a chunk at a time; keeps what it decoded last, in bounded memory.
class SampleCache {
 public:
  // A shard that comes in pieces brings the same path many times in a row.
  uint32_t fileIndex(const std::string& path) {
    if (paths_.empty() || paths_.back() != path) paths_.push_back(path);
    return static_cast<uint32_t>(paths_.size() - 1);
  }

  FunctionSamples read(uint32_t file, uint32_t row) {
    const std::pair<uint32_t, uint32_t> key{file, static_cast<uint32_t>(row / kChunkFunctions)};
    auto found = chunks_.find(key);
    if (found == chunks_.end()) {
      if (chunks_.size() >= kMaxChunks) chunks_.clear();
      found = chunks_.emplace(key, decode(key)).first;
    }
    const uint64_t P = found->second.phi.size() / kChunkFunctions, n = row % kChunkFunctions;
    return {&found->second.phi[n * P], &found->second.validity[n * P / 8]};
  }

 private:
  static constexpr size_t kMaxChunks = 256, kMaxReaders = 32;  // 74 MB of samples, and so many open files
  struct Chunk {
    std::vector<uint8_t> phi, validity;
  };

  Chunk decode(const std::pair<uint32_t, uint32_t>& key) {
    if (readers_.size() >= kMaxReaders && readers_.count(key.first) == 0) readers_.clear();
    const ShardReader& reader = readers_.try_emplace(key.first, paths_[key.first]).first->second;
    const uint64_t first = key.second * kChunkFunctions, P = static_cast<uint64_t>(reader.header().point_count);
    if (first >= reader.functionCount()) {
      throw InputError(paths_[key.first], "count_functions", "what it held before", std::to_string(reader.functionCount()));
    }
    Chunk chunk{std::vector<uint8_t>(kChunkFunctions * P), std::vector<uint8_t>(kChunkFunctions * P / 8)};
    reader.readSamples(first, std::min(kChunkFunctions, reader.functionCount() - first), chunk.phi.data(), chunk.validity.data());
    return chunk;
  }

  std::vector<std::string> paths_;
  std::map<uint32_t, ShardReader> readers_;
  std::map<std::pair<uint32_t, uint32_t>, Chunk> chunks_;
};

}  // namespace

struct DuplicateFilter::Impl {
  struct Place {
    uint32_t file, row;
  };

  FunctionSamples samples(uint64_t id) {
    const auto P = static_cast<uint64_t>(current->point_count);
    // those of the shard at work have moved to the front of its arrays
    if (id >= first_of_current) {
      const uint64_t n = id - first_of_current;
      return {&current->phi[n * P], &current->validity[n * P / 8]};
    }
    return earlier ? earlier(id) : cache.read(places[id].file, places[id].row);
  }

  DuplicateIndex::Fetch earlier;
  SampleCache cache;
  std::vector<Place> places;  // by id
  std::optional<DuplicateIndex> index;
  DuplicateRule rule;
  const Shard* current = nullptr;
  uint64_t first_of_current = 0;
};

DuplicateFilter::DuplicateFilter(DuplicateIndex::Fetch earlier) : impl_(std::make_unique<Impl>()) {
  impl_->earlier = std::move(earlier);
}

DuplicateFilter::~DuplicateFilter() = default;

void DuplicateFilter::removeKnown(Shard* shard) {
  Impl& m = *impl_;
  if (!m.index) {
    m.rule = shard->duplicate_rule;
    m.index.emplace(m.rule, shard->point_count, [&m](uint64_t id) { return m.samples(id); });
  }
  if (!(shard->duplicate_rule == m.rule)) {
    const auto text = [](const DuplicateRule& rule) {
      return std::to_string(rule.rms) + " and " + std::to_string(rule.validity_points);
    };
    throw InputError(shard->path, "attributes duplicate_rms and duplicate_validity_points",
                     text(m.rule) + " as in the first shard", text(shard->duplicate_rule));
  }
  NLG_CHECK(m.earlier || !shard->path.empty(), ==, true);
  m.current = shard;
  m.first_of_current = m.index->functionCount();
  const uint32_t file = m.cache.fileIndex(shard->path);
  const uint64_t count = shard->functionCount(), P = static_cast<uint64_t>(shard->point_count);
  uint64_t kept = 0;
  for (uint64_t n = 0; n < count; ++n) {
    if (m.index->findOrAdd({&shard->phi[n * P], &shard->validity[n * P / 8]})) continue;
    if (!m.earlier) m.places.push_back({file, static_cast<uint32_t>(shard->first_function + n)});
    if (n != kept) {
      forEachArray(*shard, [&](const char*, auto& rows, const auto& columns) { moveRow(rows, rowWidth(columns), n, kept); });
    }
    ++kept;
  }
  forEachArray(*shard, [&](const char*, auto& rows, const auto& columns) { rows.resize(kept * rowWidth(columns)); });
  shard->counts.functions -= count - kept;
  shard->counts.duplicates += count - kept;
  m.current = nullptr;
}

}  // namespace nlg
