#include "train/generator/data/function_cache.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <limits>
#include <numeric>
#include <string_view>
#include <system_error>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include "nlg/policy.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

constexpr uint64_t kOrderSeed = 0x6361636865;  // "cache": part of the format

std::string reason() { return std::generic_category().message(errno); }

// The whole file, read-only. Pages that are not used again go when the memory is wanted elsewhere.
const uint8_t* mapFile(const std::string& path, size_t* count) {
  const InputFile file(path);
  *count = file.size();
  if (*count < kFirstRecord) {
    throw DamageError(path, "size", "a function cache of at least " + std::to_string(kFirstRecord) + " bytes",
                      std::to_string(*count) + " bytes");
  }
  void* address = ::mmap(nullptr, *count, PROT_READ, MAP_SHARED, file.descriptor(), 0);
  if (address == MAP_FAILED) throw InputError(path, "map", "a file that can be mapped", reason());
  return static_cast<const uint8_t*>(address);
}

// A whole number of the footer from 0 to `most`. The library's own conversion takes fractions, and makes of what is out of range
// whatever comes of it.
uint64_t wholeNumber(const std::string& path, const nlohmann::json& json, const char* key, uint64_t most) {
  const nlohmann::json& value = json.at(key);
  if (!value.is_number_unsigned() || value.get<uint64_t>() > most)
    throw InputError(path, key, "a whole number from 0 to " + std::to_string(most), value.dump().substr(0, 40));
  return value.get<uint64_t>();
}

// made before the signal comes: a handler may neither allocate nor lock
std::string& lastLine() {
  static std::string line;
  return line;
}
const char* line_data = nullptr;
size_t line_count = 0;

void endProcess(int) {
  // nothing is left to do where not even that line can be written
  if (::write(STDERR_FILENO, line_data, line_count) < 0) ::_exit(static_cast<int>(ExitCode::internal_error));
  ::_exit(static_cast<int>(ExitCode::input_error));
}

}  // namespace

FunctionCache::FunctionCache(const std::string& path) : path_(path), mapped_(mapFile(path, &mapped_count_)) {
  try {
    CacheHead head;
    std::memcpy(&head, mapped_, sizeof head);
    // where the head names no place of a footer, there is none to verify
    const bool has_footer = head.footer_first >= kFirstRecord && head.footer_first <= mapped_count_;
    const size_t footer_first = has_footer ? head.footer_first : mapped_count_;
    const std::string footer(reinterpret_cast<const char*>(mapped_) + footer_first, mapped_count_ - footer_first);
    const bool is_footer_whole = has_footer && sha256(footer) == std::string(head.footer_sha256, sizeof head.footer_sha256);
    if (std::memcmp(head.magic, kCacheMagic, sizeof kCacheMagic) != 0) {
      // of anything but a cache these bytes are no SHA-256 of the others
      if (is_footer_whole)
        throw DamageError(path, "first bytes", "those of a function cache", "other bytes: the file is damaged");
      throw InputError(path, "first bytes", "those of a function cache", "other bytes");
    }
    if (head.version != kCacheVersion) {
      throw InputError(path, "version", std::to_string(kCacheVersion) + " (make caches of other versions again)",
                       std::to_string(head.version));
    }
    if (std::any_of(mapped_ + sizeof head, mapped_ + kFirstRecord, [](uint8_t byte) { return byte != 0; })) {
      throw DamageError(path, "bytes behind the head", "zeros", "other bytes: the file is damaged");
    }
    if (!has_footer) throw DamageError(path, "footer", "a whole file", "a file of " + std::to_string(mapped_count_) + " bytes");
    if (!is_footer_whole) {
      throw DamageError(path, "SHA-256 of the footer", "that of the head", "another digest: the file is truncated or damaged");
    }
    readFooter(footer);
    // records of one length fill the file up to its footer
    const size_t expected = kFirstRecord + recordBytes(coefficient_count_) * static_cast<size_t>(function_count_);
    if (head.footer_first != expected) {
      throw InputError(path, "footer", "at byte " + std::to_string(expected), std::to_string(head.footer_first));
    }
  } catch (...) {
    ::munmap(const_cast<uint8_t*>(mapped_), mapped_count_);
    throw;
  }
}

FunctionCache::~FunctionCache() { ::munmap(const_cast<uint8_t*>(mapped_), mapped_count_); }

// JSON, a line's end, the tent's RMSE of every function.
void FunctionCache::readFooter(const std::string& footer) {
  const size_t json_count = std::min(footer.find('\n'), footer.size());
  try {
    const nlohmann::json json = nlohmann::json::parse(footer.substr(0, json_count));
    const uint64_t hash = wholeNumber(path_, json, "pattern_hash", std::numeric_limits<uint64_t>::max());
    if (hash != supportPattern().hash) {
      throw InputError(path_, "pattern_hash", std::to_string(supportPattern().hash), std::to_string(hash));
    }
    // no more functions than the footer has bytes: each has four of them
    function_count_ = static_cast<int64_t>(wholeNumber(path_, json, "function_count", footer.size() / sizeof(float)));
    coefficient_count_ = static_cast<int>(wholeNumber(path_, json, "coefficient_count", std::numeric_limits<int>::max()));
    origin_ = {json.at("basis_sha256").get<std::string>(), json.at("training_set_sha256").get<std::string>(),
               json.at("scenes").get<std::map<std::string, std::string>>()};
    block_sha256_ = json.at("block_sha256").get<std::vector<std::string>>();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path_, "footer", "the footer of a function cache", error.what());
  }
  // counts must agree before anything is read by them
  const int64_t block_count = (function_count_ + kBlockFunctions - 1) / kBlockFunctions;
  const size_t rmse_bytes = static_cast<size_t>(function_count_) * sizeof(float);
  if (function_count_ < 1 || coefficient_count_ < 1 || blockCount() != block_count ||
      footer.size() != json_count + 1 + rmse_bytes) {
    throw InputError(path_, "footer", "counts that agree", std::to_string(function_count_) + " functions");
  }
  tent_rmse_.resize(static_cast<size_t>(function_count_));
  std::memcpy(tent_rmse_.data(), footer.data() + json_count + 1, rmse_bytes);
  checked_.assign(block_sha256_.size(), false);
}

StoredFunction FunctionCache::function(int64_t index) const {
  const uint8_t* record = mapped_ + kFirstRecord + recordBytes(coefficient_count_) * static_cast<size_t>(index);
  const uint8_t* validity = record + kSupportPointCount;
  return {record, validity, validity + kValidityByteCount, validity + 2 * kValidityByteCount};
}

const float* FunctionCache::coefficients(int64_t index) const {
  // aligned: the page and all parts of a record before it are multiples of a float
  return reinterpret_cast<const float*>(function(index).blend_sum + kSupportPointCount);
}

float FunctionCache::tentRmse(int64_t index) const { return tent_rmse_[static_cast<size_t>(index)]; }

FunctionCache::Span FunctionCache::blockSpan(int64_t block) const {
  const int64_t first = block * kBlockFunctions, count = std::min(kBlockFunctions, function_count_ - first);
  return {function(first).phi, recordBytes(coefficient_count_) * static_cast<size_t>(count)};
}

void FunctionCache::adviseBlock(int64_t block) const {
  const Span span = blockSpan(block);
  const auto page = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
  const size_t first = static_cast<size_t>(span.first - mapped_) / page * page;
  const size_t end = static_cast<size_t>(span.first - mapped_) + span.count;
  // advice: where the system does not take it, loadBlock reads all the same
  (void)::madvise(const_cast<uint8_t*>(mapped_) + first, end - first, MADV_WILLNEED);
}

void FunctionCache::loadBlock(int64_t block) {
  const Span span = blockSpan(block);
  if (!checked_[static_cast<size_t>(block)]) {
    const std::string_view bytes(reinterpret_cast<const char*>(span.first), span.count);
    if (sha256(bytes) != block_sha256_[static_cast<size_t>(block)]) {
      throw DamageError(path_, "SHA-256 of block " + std::to_string(block), "that of the footer",
                        "another digest: the file is damaged");
    }
    checked_[static_cast<size_t>(block)] = true;
    return;
  }
  const volatile uint8_t* bytes = span.first;
  for (size_t i = 0; i < span.count; i += 1024) (void)bytes[i];
}

float tentRmse(const StoredFunction& function) {
  static const std::vector<float> tents = [] {
    std::vector<float> values;
    for (int p = 0; p < kSupportPointCount; ++p) values.push_back(tent(supportPattern().points[p]));
    return values;
  }();
  static const LossWeights weights(CheckOptions().loss());
  double sum = 0.0;
  int count = 0;
  for (int p = 0; p < kSupportPointCount; ++p) {
    if (!function.isValid(p)) continue;
    const double difference = function.phi[p] / 255.0 - static_cast<double>(tents[p]);
    const double residual = difference * weights.root(function.phi[p], tents[p], function.blendSum(p));
    sum += residual * residual;
    ++count;
  }
  return count > 0 ? static_cast<float>(std::sqrt(sum / count)) : 0.0f;
}

std::vector<uint32_t> cacheOrder(int64_t count) {
  // keys of their own for every index: the order of the first n does not depend on how many follow
  std::vector<uint64_t> keys(static_cast<size_t>(count));
  for (size_t i = 0; i < keys.size(); ++i) keys[i] = mixSeed(kOrderSeed, i);
  std::vector<uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  return order;
}

void endWhenPagesVanish(const std::string& tool, const std::string& path) {
  const InputError error(path, "mapped pages", "a file that stays as it is while it is read",
                         "one that was shortened, or a disk that failed");
  std::signal(SIGBUS, SIG_DFL);
  lastLine() = tool + ": error: " + error.what() + "\n";
  line_data = lastLine().data();
  line_count = lastLine().size();
  std::signal(SIGBUS, endProcess);
}

}  // namespace nlg
