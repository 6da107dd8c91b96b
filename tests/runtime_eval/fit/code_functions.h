// Functions that a dictionary can make, and what decides how near a fit comes to them.
#pragma once

#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_fields.h"

namespace nlg {

// The function of a code, as a data set stores it; every point is valid.
// noise   of every byte, uniform, to either side
inline StoredSample codeSample(const SharedDictionary& dictionary, const Theta& z, int noise = 0) {
  const PointSet points = makePointSet(supportPattern().points);
  AlignedFloats values(points.padded_count);
  evaluate(Representation::code(dictionary), points, z.data(), values.data());
  Random random(mixSeed(z.size(), 3));
  StoredSample sample;
  for (int p = 0; p < kSupportPointCount; ++p) {
    const int off = static_cast<int>(random.below(static_cast<uint64_t>(2 * noise + 1))) - noise;
    sample.phi[p] = static_cast<uint8_t>(std::clamp<long>(std::lround(255.0f * values[p]) + off, 0, 255));
  }
  std::fill(sample.validity.begin(), sample.validity.end(), uint8_t{255});
  return sample;
}

// The function of a code whose later numbers matter less, as those of an ordered dictionary do.
inline StoredSample fallingSample(const SharedDictionary& dictionary, uint64_t seed) {
  Random random(seed);
  Theta z = sampleCode(*dictionary, dictionary->codeCount(), random);
  for (size_t k = 0; k < z.size(); ++k) z[k] = std::nearbyint(z[k] * std::exp(-static_cast<float>(k) / 8.0f));
  return codeSample(dictionary, z, 3);
}

// By place of a cell order: where it holds a point the b_k there, and the logit of a code that is not rounded.
struct CodeAtPlaces {
  std::vector<std::vector<double>> rows;
  std::vector<double> logits;
};
inline CodeAtPlaces atPlaces(const Dictionary& dictionary, const PointOrder& order, const std::vector<double>& z) {
  const int r = dictionary.resolution(), K = dictionary.codeCount();
  CodeAtPlaces all{std::vector(static_cast<size_t>(order.placeCount()), std::vector<double>(static_cast<size_t>(K))), {}};
  for (int place = 0; place < order.placeCount(); ++place) {
    const LocalPoint at = placePosition(order, place);
    int low[3];
    double share[3], logit = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double along = (static_cast<double>(at[axis]) + 1.0) * 0.5 * (r - 1);
      low[axis] = std::min(static_cast<int>(along), r - 2);
      share[axis] = along - low[axis];
    }
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1.0;
      int node = 0;
      for (int axis = 2; axis >= 0; --axis) {
        weight *= corner >> axis & 1 ? share[axis] : 1.0 - share[axis];
        node = node * r + low[axis] + (corner >> axis & 1);
      }
      for (int k = 0; k < K; ++k) all.rows[place][k] += weight * dictionary.row(k)[node];
      logit += weight * dictionary.row(K)[node];
    }
    for (int k = 0; k < K; ++k) logit += z[k] * all.rows[place][k];
    all.logits.push_back(logit);
  }
  return all;
}

}  // namespace nlg
