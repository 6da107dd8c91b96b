#include "bake/function_sharing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "runtime_eval/evaluator/evaluate.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr int kGlancePoints = kMinibatchPointCount;  // well spread over the support
constexpr int kGlanceGroup = 32;                     // between two looks at whether it is too much already
constexpr double kGlanceSlack = 1.6;                 // what errors at so few points may be off by
constexpr uint64_t kAsked = 1024;                    // functions that say who might stand for them, by which others are ordered
constexpr size_t kMostTries = 64;                    // checks of one function; what passes is mostly the first
constexpr uint64_t kBlockFunctions = 256;

using Values = std::array<float, kGlancePoints>;

// A function at these points.
struct Glance {
  Values phi{}, weight{};  // weight 0 where a point is not valid
  float most = 0.0f;       // of weighed squared residuals
};

float glanceDistance(const Glance& of, const Values& values) {
  float sum = 0.0f;
  for (int begin = 0; begin < kGlancePoints && sum <= of.most; begin += kGlanceGroup) {
    std::array<float, 8> lanes{};
    for (int p = begin; p < begin + kGlanceGroup; p += 8) {
      for (int lane = 0; lane < 8; ++lane) {
        const float residual = of.phi[p + lane] - values[p + lane];
        lanes[lane] += of.weight[p + lane] * residual * residual;
      }
    }
    sum += std::accumulate(lanes.begin(), lanes.end(), 0.0f);
  }
  return sum;
}

class ThetaSharing {
 public:
  ThetaSharing(const std::vector<MadeTheta>& made, const std::vector<Generator>& generators, const ReadFunction& read,
               const CheckOptions& options, double share_rmse, int thread_count)
      : made_(made),
        generators_(generators),
        read_(read),
        options_(options),
        weights_(options.loss()),
        share_rmse_(share_rmse),
        thread_count_(thread_count),
        threads_(static_cast<size_t>(thread_count)),
        values_(made.size()) {
    shared_.whose.resize(made.size());
    std::iota(shared_.whose.begin(), shared_.whose.end(), 0u);
    for (const MadeTheta& one : made) shared_.check.push_back(one.check());
  }

  SharedThetas run() {
    evaluateAll();
    const std::vector<uint32_t> order = mostAskedForFirst();
    for (size_t begin = 0; begin < order.size(); begin += kBlockFunctions) {
      const size_t count = std::min<size_t>(kBlockFunctions, order.size() - begin), staying = staying_.size();
      parallelFor(count, thread_count_, [&](uint64_t i, int thread) { findAnother(order[begin + i], 0, thread); });
      // among themselves one after another
      for (size_t i = begin; i < begin + count; ++i) {
        if (shared_.whose[order[i]] == order[i] && !findAnother(order[i], staying, 0)) staying_.push_back(order[i]);
      }
    }
    shared_.count = made_.size() - staying_.size();
    return std::move(shared_);
  }

 private:
  struct Thread {
    FunctionChecker checker;
    std::vector<uint8_t> samples;
    std::vector<std::pair<float, uint32_t>> near;
  };

  const Representation& representationOf(uint32_t function) const {
    return generators_[made_[function].generator].representation();
  }

  double mostRmse(uint32_t function) const { return std::max(share_rmse_, made_[function].check().blend_rmse); }

  void evaluateAll() {
    std::vector<LocalPoint> points;
    for (int place = 0; place < kGlancePoints; ++place) points.push_back(supportPattern().points[stratifiedPatternIndex(place)]);
    const PointSet set = makePointSet(points);
    parallelFor(made_.size(), thread_count_, [&](uint64_t function, int) {
      AlignedFloats values(set.padded_count);
      evaluate(representationOf(static_cast<uint32_t>(function)), set, made_[function].theta.data(), values.data());
      std::copy_n(values.begin(), kGlancePoints, values_[function].begin());
    });
  }

  Glance glanceAt(uint32_t function, const StoredFunction& stored) const {
    Glance glance;
    int valid = 0;
    for (int place = 0; place < kGlancePoints; ++place) {
      const int point = stratifiedPatternIndex(place);
      if (!stored.isValid(point)) continue;
      ++valid;
      glance.phi[place] = static_cast<float>(stored.phi[point]) / 255.0f;
      const float root = weights_.root(stored.phi[point], tent(supportPattern().points[point]), stored.blendSum(point));
      glance.weight[place] = root * root;
    }
    const double most = kGlanceSlack * mostRmse(function);
    glance.most = static_cast<float>(most * most * valid);
    return glance;
  }

  std::vector<uint32_t> mostAskedForFirst() {
    const uint64_t every = (made_.size() + kAsked - 1) / kAsked;
    std::vector<Glance> asked(every > 0 ? (made_.size() + every - 1) / every : 0);
    parallelFor(asked.size(), thread_count_, [&](uint64_t i, int thread) {
      const auto function = static_cast<uint32_t>(i * every);
      asked[i] = glanceAt(function, read_(function, &threads_[thread].samples));
    });
    std::vector<uint32_t> order(made_.size()), times(made_.size());
    parallelFor(made_.size(), thread_count_, [&](uint64_t function, int) {
      times[function] = static_cast<uint32_t>(std::count_if(asked.begin(), asked.end(), [&](const Glance& glance) {
        return glanceDistance(glance, values_[function]) <= glance.most;
      }));
    });
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return times[a] > times[b]; });
    return order;
  }

  // Of those that stay, from a place in their list on; the closest at a glance first.
  bool findAnother(uint32_t function, size_t from, int thread_idx) {
    if (from == staying_.size()) return false;
    Thread& thread = threads_[thread_idx];
    const StoredFunction stored = read_(function, &thread.samples);
    const Glance glance = glanceAt(function, stored);
    thread.near.clear();
    for (size_t s = from; s < staying_.size(); ++s) {
      const float distance = glanceDistance(glance, values_[staying_[s]]);
      if (distance <= glance.most) thread.near.emplace_back(distance, staying_[s]);
    }
    const size_t tries = std::min(kMostTries, thread.near.size());
    std::partial_sort(thread.near.begin(), thread.near.begin() + static_cast<std::ptrdiff_t>(tries), thread.near.end());
    const double most_trouble = std::max(1.0, made_[function].check().trouble(options_));
    for (size_t t = 0; t < tries; ++t) {
      const uint32_t other = thread.near[t].second;
      const FunctionCheck check = thread.checker.check(representationOf(other), stored, made_[other].theta.data(), options_);
      if (check.trouble(options_) > most_trouble || check.blend_rmse > mostRmse(function)) continue;
      shared_.whose[function] = other;
      shared_.check[function] = check;
      return true;
    }
    return false;
  }

  const std::vector<MadeTheta>& made_;
  const std::vector<Generator>& generators_;
  const ReadFunction& read_;
  const CheckOptions& options_;
  const LossWeights weights_;
  const double share_rmse_;
  const int thread_count_;
  std::vector<Thread> threads_;
  std::vector<Values> values_;     // by function: of its theta
  std::vector<uint32_t> staying_;  // functions whose theta is stored
  SharedThetas shared_;
};

}  // namespace

SharedThetas shareThetas(const std::vector<MadeTheta>& made, const std::vector<Generator>& generators, const ReadFunction& read,
                         const CheckOptions& options, double share_rmse, int thread_count) {
  return ThetaSharing(made, generators, read, options, share_rmse, thread_count).run();
}

}  // namespace nlg
