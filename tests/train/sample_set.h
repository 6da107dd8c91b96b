// A small set of weighting functions in memory: probes beside random walls.
#pragma once

#include "datagen/dataset/function_set.h"
#include "tests/runtime_eval/sample_functions.h"

namespace nlg {

inline FunctionSet sampleSet(int count, uint64_t first_seed) {
  FunctionSet set;
  set.pattern_hash = supportPattern().hash;
  set.point_count = kSupportPointCount;
  set.scene_ids = {"sample"};
  set.families = {"sample"};
  set.scene_idx.assign(count, 0);
  set.sha256 = "sample set " + std::to_string(count) + " from " + std::to_string(first_seed);
  for (int n = 0; n < count; ++n) {
    const StoredSample sample = crowdedSample(first_seed + static_cast<uint64_t>(n));
    set.phi.insert(set.phi.end(), sample.phi.begin(), sample.phi.end());
    set.validity.insert(set.validity.end(), sample.validity.begin(), sample.validity.end());
    set.blend_sum.insert(set.blend_sum.end(), sample.blend_sum.begin(), sample.blend_sum.end());
  }
  set.seen = set.validity;
  set.counts.functions = static_cast<uint64_t>(count);
  return set;
}

}  // namespace nlg
