#include "runtime_eval/support/weighting_function.h"

namespace nlg {
namespace {

// A stratum: an octant is 1024 samples and 128 validity bytes; bit k of a validity byte belongs to stratum k.
int decodeStratum(const PointOrder& order, const StoredFunction& stored, int stratum, int mirror, const LossWeights& weights,
                  float* phi, float* mask) {
  constexpr int kQuarters = kStratumPointCount / kMinibatchPointCount, kRun = kMinibatchPointCount / kMirrorCount;
  const float* tent = &order.points.tent[order.batch_begin[stratum]];
  int valid_count = 0;
  // places as stratifiedPatternIndex orders them; a mirror image swaps whole octants (docs/theory/math.md §2)
  for (int s = 0; s < kQuarters; ++s) {
    for (int m = 0; m < kMirrorCount; ++m) {
      const int octant = (m ^ mirror) * kOctantPointCount;
      for (int t = 0; t < kRun; ++t) {
        const int source = octant + 8 * (kQuarters * t + s);
        const int valid = (stored.validity[source / 8] >> stratum) & 1;
        const uint8_t byte = stored.phi[source + stratum];
        *phi++ = static_cast<float>(byte) * (1.0f / 255.0f);
        *mask++ = valid ? weights.root(byte, *tent, stored.blendSum(source + stratum)) : 0.0f;
        ++tent;
        valid_count += valid;
      }
    }
  }
  return valid_count;
}

}  // namespace

int decodeBatch(const PointOrder& order, int batch, const StoredFunction& stored, int mirror, const LossWeights& weights,
                float* phi, float* mask) {
  if (order.resolution == 0) return decodeStratum(order, stored, batch, mirror, weights, phi, mask);
  int valid_count = 0;
  const int begin = order.batch_begin[batch], end = order.batch_begin[batch + 1];
  for (int place = begin; place < end; ++place) {
    const int pattern = order.pattern_index[place];
    const int source = pattern ^ (mirror * kOctantPointCount);
    const int valid = pattern < 0 ? 0 : stored.validity[source / 8] >> (source % 8) & 1;
    phi[place - begin] = pattern < 0 ? 0.0f : static_cast<float>(stored.phi[source]) * (1.0f / 255.0f);
    mask[place - begin] = valid ? weights.root(stored.phi[source], order.points.tent[place], stored.blendSum(source)) : 0.0f;
    valid_count += valid;
  }
  return valid_count;
}

int WeightingFunction::validCount() const {
  int total = 0;
  for (const int count : valid_count) total += count;
  return total;
}

WeightingFunction decodeFunction(const StoredFunction& stored, const PointOrder& order, const LossOptions& loss) {
  WeightingFunction function;
  decodeFunction(stored, order, loss, &function);
  return function;
}

void decodeFunction(const StoredFunction& stored, const PointOrder& order, const LossOptions& loss, WeightingFunction* function) {
  const LossWeights weights(loss);
  function->phi.resize(order.placeCount());
  function->mask.resize(order.placeCount());
  function->valid_count.resize(order.batchCount());
  for (int b = 0; b < order.batchCount(); ++b) {
    const int begin = order.batch_begin[b];
    function->valid_count[b] = decodeBatch(order, b, stored, 0, weights, &function->phi[begin], &function->mask[begin]);
  }
  function->dark_root = weights.darkRoot();
}

WeightingFunction functionFromSamples(const std::vector<float>& phi, const std::vector<bool>& valid, const PointOrder& order) {
  WeightingFunction function;
  for (int b = 0; b < order.batchCount(); ++b) {
    int valid_count = 0;
    for (int place = order.batch_begin[b]; place < order.batch_begin[b + 1]; ++place) {
      const int pattern = order.pattern_index[place];
      const bool used = pattern >= 0 && valid[pattern];
      function.phi.push_back(pattern < 0 ? 0.0f : phi[pattern]);
      function.mask.push_back(used ? 1.0f : 0.0f);
      valid_count += used;
    }
    function.valid_count.push_back(valid_count);
  }
  return function;
}

WeightingFunction reordered(const WeightingFunction& function, const PointOrder& from, const PointOrder& to) {
  std::vector<float> phi(kSupportPointCount), mask(kSupportPointCount);
  for (int place = 0; place < from.placeCount(); ++place) {
    const int pattern = from.pattern_index[place];
    if (pattern < 0) continue;
    phi[pattern] = function.phi[place];
    mask[pattern] = function.mask[place];
  }
  WeightingFunction result = functionFromSamples(phi, std::vector<bool>(mask.begin(), mask.end()), to);
  // the mask may weigh points, not only leave them out
  result.dark_root = function.dark_root;
  for (int place = 0; place < to.placeCount(); ++place) {
    const int pattern = to.pattern_index[place];
    if (pattern >= 0) result.mask[place] = mask[pattern];
  }
  return result;
}

WeightingFunction tentFunction(const PointOrder& order) {
  std::vector<float> phi;
  for (const LocalPoint& point : supportPattern().points) phi.push_back(tent(point));
  return functionFromSamples(phi, std::vector<bool>(phi.size(), true), order);
}

}  // namespace nlg
