#include "validate/errors/held_out.h"

#include "runtime_eval/support/support_pattern.h"
#include "tool/error.h"

namespace nlg {

FunctionSet readHeldOut(const std::vector<std::string>& paths) {
  FunctionSet set = readFunctionSet(paths, supportPattern().hash, kSupportPointCount);
  if (set.functionCount() == 0) throw InputError(paths.front(), "held-out functions", "at least one in all shards", "none");
  if (set.test_point_count == 0)
    throw InputError(paths.front(), "test points", "shards made with --held-out", "shards without them");
  if (const uint64_t expected = hashPoints(testPoints(set.test_point_count)); set.test_pattern_hash != expected) {
    throw InputError(paths.front(), "attribute test_pattern_hash", std::to_string(expected),
                     std::to_string(set.test_pattern_hash));
  }
  return set;
}

}  // namespace nlg
