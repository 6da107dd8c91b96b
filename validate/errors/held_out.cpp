#include "validate/errors/held_out.h"

#include "tool/error.h"
#include "tool/require_read.h"

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

namespace {

constexpr const char* kExpected = "a generator of this support pattern";

}  // namespace

Generator loadGenerator(const std::string& path) {
  Generator generator;
  requireRead(path, Generator::load(path, &generator), kExpected);
  return generator;
}

GeneratorData loadGeneratorData(const std::string& path) {
  loadGenerator(path);  // obeys NLG_SIMD, which numbers alone do not
  WeightsFile file;
  GeneratorData data;
  requireRead(path, readWeightsFile(path, &file), kExpected);
  requireRead(path, generatorFromWeights(file, &data), kExpected);
  return data;
}

}  // namespace nlg
