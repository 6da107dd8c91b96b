#include "tool/require_read.h"

#include <iostream>
#include <mutex>
#include <set>

#include "tool/error.h"

namespace nlg {
namespace {

// What the bytes themselves prove: no writer of ours left them so.
bool isDamage(WeightsStatus status) {
  return status == WeightsStatus::too_short || status == WeightsStatus::header_too_large ||
         status == WeightsStatus::header_malformed || status == WeightsStatus::tensor_malformed ||
         status == WeightsStatus::digest_mismatch;
}

}  // namespace

void requireRead(const std::string& path, const WeightsResult& result, const std::string& expected) {
  const char* status = weightsStatusName(result.status);
  if (isDamage(result.status)) throw DamageError(path, status, expected, result.detail);
  if (!result.ok()) throw InputError(path, status, expected, result.detail);
  if (!result.detail.empty()) sayUnchecked(result.detail);
}

void sayUnchecked(const std::string& line) {
  // some tools read a file twice
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  if (said.insert(line).second) std::cerr << "unchecked: " << line << '\n';
}

}  // namespace nlg
