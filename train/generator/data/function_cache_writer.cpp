#include "train/generator/data/function_cache_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <nlohmann/json.hpp>

#include "datagen/dataset/function_set.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/progress.h"

namespace nlg {
namespace {

// The temporary file: bytes at any place.
class RandomFile {
 public:
  RandomFile(const std::string& temporary_path, const std::string& path)
      : path_(path), file_(::open(temporary_path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
    if (file_ < 0) fail();
  }
  ~RandomFile() { ::close(file_); }
  RandomFile(const RandomFile&) = delete;
  RandomFile& operator=(const RandomFile&) = delete;

  void write(size_t first, const void* bytes, size_t count) {
    for (size_t done = 0; done < count;) {
      const ssize_t written =
          ::pwrite(file_, static_cast<const char*>(bytes) + done, count - done, static_cast<off_t>(first + done));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail();
      done += static_cast<size_t>(written);
    }
  }

  void read(size_t first, void* bytes, size_t count) {
    for (size_t done = 0; done < count;) {
      const ssize_t got = ::pread(file_, static_cast<char*>(bytes) + done, count - done, static_cast<off_t>(first + done));
      if (got < 0 && errno == EINTR) continue;
      if (got == 0) errno = EIO;
      if (got <= 0) fail();
      done += static_cast<size_t>(got);
    }
  }

  void truncate(size_t count) {
    if (::ftruncate(file_, static_cast<off_t>(count)) != 0) fail();
  }

 private:
  [[noreturn]] void fail() const { throw OutputError(path_, std::generic_category().message(errno)); }

  std::string path_;
  int file_;
};

// Fills one temporary file: add() shard by shard, then finish().
class CacheWriter {
 public:
  CacheWriter(RandomFile& file, const BasisData& basis, int64_t largest_count)
      : file_(file),
        projection_(basis),
        record_bytes_(recordBytes(basis.coefficientCount())),
        places_(static_cast<size_t>(largest_count)),
        tent_rmse_(places_.size()),
        filled_(places_.size(), false) {
    const std::vector<uint32_t> order = cacheOrder(largest_count);
    for (size_t place = 0; place < order.size(); ++place) places_[order[place]] = static_cast<uint32_t>(place);
  }

  int64_t functionCount() const { return count_; }

  // The samples of the id-th function; good until the next call.
  StoredFunction samples(uint64_t id) {
    fetched_.resize(recordBytes(0));
    file_.read(placeOf(places_[id]), fetched_.data(), fetched_.size());
    const uint8_t* validity = fetched_.data() + kSupportPointCount;
    return {fetched_.data(), validity, validity + kValidityByteCount, validity + 2 * kValidityByteCount};
  }

  void add(const Shard& shard) {
    const int64_t count = static_cast<int64_t>(shard.functionCount());
    if (count_ + count > static_cast<int64_t>(places_.size())) {
      throw InputError(shard.path, "functions", "as many as at the start", "more: the file has changed since");
    }
    const size_t K = static_cast<size_t>(projection_.coefficientCount());
    std::vector<float> coefficients(K * kBatchCount);
    std::vector<uint8_t> record(record_bytes_);
    for (int64_t begin = 0; begin < count; begin += kBatchCount) {
      const int batch = static_cast<int>(std::min<int64_t>(kBatchCount, count - begin));
      // projected once, so that training only reads coefficients
      std::vector<StoredFunction> functions;
      for (int b = 0; b < batch; ++b) functions.push_back(storedFunction(shard, static_cast<size_t>(begin + b)));
      projection_.project(functions.data(), batch, coefficients.data(), &scratch_);
      for (int b = 0; b < batch; ++b) {
        const size_t place = places_[static_cast<size_t>(count_++)];
        const StoredFunction& function = functions[static_cast<size_t>(b)];
        uint8_t* part = std::copy_n(function.phi, kSupportPointCount, record.data());
        part = std::copy_n(function.validity, kValidityByteCount, part);
        part = std::copy_n(function.seen, kValidityByteCount, part);
        part = std::copy_n(function.blend_sum, kSupportPointCount, part);
        std::memcpy(part, &coefficients[K * static_cast<size_t>(b)], K * sizeof(float));
        file_.write(placeOf(place), record.data(), record.size());
        tent_rmse_[place] = tentRmse(function);
        filled_[place] = true;
      }
    }
  }

  // Closes the gaps that duplicates left; returns the digests of the blocks.
  std::vector<std::string> close() {
    std::vector<std::string> digests;
    std::vector<uint8_t> block;
    size_t kept = 0;
    for (size_t place = 0; place < filled_.size(); ++place) {
      if (!filled_[place]) continue;
      block.resize(block.size() + record_bytes_);
      file_.read(placeOf(place), &block[block.size() - record_bytes_], record_bytes_);
      tent_rmse_[kept++] = tent_rmse_[place];
      if (kept % kBlockFunctions == 0) writeBlock(kept, block, digests);
    }
    if (!block.empty()) writeBlock(kept, block, digests);
    tent_rmse_.resize(kept);
    file_.truncate(placeOf(kept));
    return digests;
  }

  // Behind the last record, with the head that points to it. Returns the file's size.
  uint64_t writeFooter(const nlohmann::ordered_json& json) {
    std::string footer = json.dump() + '\n';
    footer.append(reinterpret_cast<const char*>(tent_rmse_.data()), tent_rmse_.size() * sizeof(float));
    CacheHead head{};
    std::memcpy(head.magic, kCacheMagic, sizeof kCacheMagic);
    head.version = kCacheVersion;
    head.footer_first = placeOf(static_cast<size_t>(count_));
    std::memcpy(head.footer_sha256, sha256(footer).data(), sizeof head.footer_sha256);
    std::vector<uint8_t> page(kFirstRecord, 0);
    std::memcpy(page.data(), &head, sizeof head);
    file_.write(0, page.data(), page.size());
    file_.write(head.footer_first, footer.data(), footer.size());
    return head.footer_first + footer.size();
  }

 private:
  size_t placeOf(size_t place) const { return kFirstRecord + place * record_bytes_; }

  // `end` records stand before the end of this block: its place lies at or before the one that was read last.
  void writeBlock(size_t end, std::vector<uint8_t>& block, std::vector<std::string>& digests) {
    file_.write(placeOf(end) - block.size(), block.data(), block.size());
    digests.push_back(sha256({reinterpret_cast<const char*>(block.data()), block.size()}));
    block.clear();
  }

  RandomFile& file_;
  Projection projection_;
  ProjectionScratch scratch_;
  size_t record_bytes_;
  int64_t count_ = 0;
  std::vector<uint32_t> places_;  // by the order of arrival
  std::vector<float> tent_rmse_;  // by place
  std::vector<bool> filled_;      // by place
  std::vector<uint8_t> fetched_;
};

}  // namespace

CacheReport writeFunctionCache(const std::string& path, const std::vector<std::string>& shards, const BasisData& basis,
                               const std::string& basis_sha256) {
  if (shards.empty()) throw InputError("shards", "files", "at least one", "none");
  CacheOrigin origin;
  origin.basis_sha256 = basis_sha256;
  // as many as there can be: places are shuffled before anybody knows the duplicates
  int64_t largest_count = 0;
  for (const std::string& shard_path : shards) {
    const Shard header = readShardHeader(shard_path, supportPattern().hash, kSupportPointCount);
    largest_count += static_cast<int64_t>(header.counts.functions);
    origin.scenes[header.scene_id] = header.sceneSha256();
  }
  if (largest_count == 0) throw InputError(shards.front(), "functions", "at least one in all shards", "none");
  CacheReport report;
  writeAtomically(path, [&](const std::string& temporary_path) {
    // one pass: every record goes straight to its shuffled place, whatever the memory
    RandomFile file(temporary_path, path);
    CacheWriter writer(file, basis, largest_count);
    DuplicateFilter filter([&](uint64_t id) { return writer.samples(id); });
    Progress progress("shards", static_cast<int64_t>(shards.size()));
    std::string hashes;
    for (size_t i = 0; i < shards.size(); ++i) {
      Shard shard = readShard(shards[i], supportPattern().hash, kSupportPointCount);
      filter.removeKnown(&shard);
      writer.add(shard);
      hashes += fileSha256(shards[i]);
      progress.update(static_cast<int64_t>(i + 1));
    }
    const std::vector<std::string> digests = writer.close();
    report = {writer.functionCount(), largest_count - writer.functionCount(), 0};
    report.bytes = writer.writeFooter({{"pattern_hash", supportPattern().hash},
                                       {"function_count", report.functions},
                                       {"coefficient_count", basis.coefficientCount()},
                                       {"basis_sha256", basis_sha256},
                                       {"training_set_sha256", sha256(hashes)},
                                       {"scenes", origin.scenes},
                                       {"block_sha256", digests}});
  });
  return report;
}

}  // namespace nlg
