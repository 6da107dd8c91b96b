// Hostile function caches: whatever the bytes, they are refused in one line, or every function can be read.
//
// An input is a file as it stands, or a footer alone, behind one byte: its records, its head and the SHA-256 there are made here,
// or no mutation would get past them; and where that byte is odd, so is that of the only block.
#include <cstring>

#include <nlohmann/json.hpp>

#include "tests/fuzz/fuzz.h"
#include "tool/atomic_file.h"
#include "train/generator/data/function_cache.h"

namespace nlg::fuzz {
namespace {

constexpr int64_t kMaxFunctions = 3, kMaxCoefficients = 4;

// A small number of the footer; 0 for anything else.
int64_t smallNumber(const nlohmann::json& json, const char* key, int64_t limit) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_number_integer()) return 0;
  const int64_t value = json[key].get<int64_t>();
  return value >= 0 && value <= limit ? value : 0;
}

std::string headOf(const std::string& footer, size_t record_bytes) {
  CacheHead head{};
  std::memcpy(head.magic, kCacheMagic, sizeof kCacheMagic);
  head.version = kCacheVersion;
  head.footer_first = kFirstRecord + record_bytes;
  std::memcpy(head.footer_sha256, sha256(footer).data(), sizeof head.footer_sha256);
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  bytes.resize(kFirstRecord, '\0');
  return bytes;
}

std::string wholeFile(std::string_view input) {
  if (input.starts_with("nlgcache")) return std::string(input);
  const bool has_right_block = !input.empty() && (input[0] & 1) != 0;
  std::string footer(input.substr(std::min<size_t>(input.size(), 1)));
  const size_t end = std::min(footer.find('\n'), footer.size());
  nlohmann::json json = nlohmann::json::parse(footer.substr(0, end), nullptr, false);
  const int64_t coefficients = smallNumber(json, "coefficient_count", kMaxCoefficients);
  const int64_t functions = smallNumber(json, "function_count", kMaxFunctions);
  const std::string records(recordBytes(static_cast<int>(coefficients)) * static_cast<size_t>(functions), 'r');
  if (has_right_block && json.is_object()) {
    json["block_sha256"] = {sha256(records)};
    // a text that is no UTF-8 has no dump
    footer.replace(0, end, json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  return headOf(footer, records.size()) + records + footer;
}

void readAll(const std::string& path) {
  FunctionCache cache(path);
  FUZZ_CHECK(cache.functionCount() > 0 && cache.coefficientCount() > 0, std::to_string(cache.functionCount()));
  for (int64_t block = 0; block < cache.blockCount(); ++block) {
    cache.adviseBlock(block);
    cache.loadBlock(block);
    cache.loadBlock(block);
  }
  uint64_t sum = 0;
  for (int64_t i = 0; i < cache.functionCount(); ++i) {
    const StoredFunction function = cache.function(i);
    sum += function.phi[kSupportPointCount - 1] + function.validity[kValidityByteCount - 1];
    sum += static_cast<uint64_t>(cache.coefficients(i)[cache.coefficientCount() - 1] > 0.0f) + (cache.tentRmse(i) > 0.0f);
  }
  FUZZ_CHECK(sum > 0 || cache.functionCount() > 0, "read to the end");
}

std::string footerOf(int functions) {
  const nlohmann::ordered_json json = {{"pattern_hash", supportPattern().hash},
                                       {"function_count", functions},
                                       {"coefficient_count", 1},
                                       {"basis_sha256", "basis"},
                                       {"training_set_sha256", "set"},
                                       {"scenes", {{"house", ""}, {"maze", ""}}},
                                       {"block_sha256", {"none"}}};
  return json.dump() + '\n' + std::string(static_cast<size_t>(functions) * sizeof(float), '\0');
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile file("functions.cache");
  file.write(wholeFile(bytes));
  isTaken([] { readAll(file.path()); });
}

Seeds seeds() {
  const ScratchFile file("seed");
  file.write(wholeFile("1" + footerOf(2)));
  // a seed that is refused would be none
  readAll(file.path());
  return {{"two", "1" + footerOf(2)}, {"one", "0" + footerOf(1)}, {"head", file.read().substr(0, 256)}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return mutatedTextOrBlindly(std::move(bytes), max_size, random);
}

}  // namespace nlg::fuzz
