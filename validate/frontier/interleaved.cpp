#include "validate/frontier/interleaved.h"

#include <cmath>

#include "tool/error.h"
#include "validate/frontier/stopwatch.h"

namespace nlg {
namespace {

BlockTimes timesOf(size_t block, const std::vector<FittedFunction>& functions) {
  BlockTimes times{block, {}};
  for (const FittedFunction& function : functions) times.elapsed_us.push_back(function.elapsed_us);
  return times;
}

class Interleaved {
 public:
  Interleaved(const FunctionSet& set, const std::vector<FunctionBlock>& blocks, const std::vector<PlotPoint>& points)
      : blocks_(blocks), points_(points), meter_(set), measured_(points.size()), block_s_(points.size(), 0.0) {}

  // The first run on a block: errors, and how long it takes.
  void measureErrors(size_t p, size_t b) {
    const WallStopwatch watch;
    const std::vector<FittedFunction> functions = points_[p].run(blocks_[b]);
    if (b == 0) block_s_[p] = 1e-6 * watch.elapsedUs();
    NLG_CHECK(functions.size(), ==, blocks_[b].functions.size());
    PointMeasurement& point = measured_[p];
    for (size_t i = 0; i < functions.size(); ++i) {
      const uint64_t function = blocks_[b].functions[i];
      point.errors.push_back(meter_.measure(functions[i].representation, functions[i].theta.data(), function, &point.leaks));
      if (!std::isfinite(point.errors.back().rmse)) {
        throw NumericalError("validate frontier", points_[p].representation + ": " + points_[p].label,
                             "RMSE of function " + std::to_string(function), point.errors.back().rmse);
      }
    }
    point.times.push_back(timesOf(b, functions));
  }

  bool isShort(size_t p, const InterleaveOptions& options) const { return block_s_[p] <= options.repeat_seconds; }

  // The times of cold caches are not those that the repeats are about to give.
  void forgetTimes(size_t p) { measured_[p].times.clear(); }

  void repeat(size_t p, size_t b) {
    points_[p].run(blocks_[b]);
    measured_[p].times.push_back(timesOf(b, points_[p].run(blocks_[b])));
  }

  std::vector<PointMeasurement> take() { return std::move(measured_); }

 private:
  const std::vector<FunctionBlock>& blocks_;
  const std::vector<PlotPoint>& points_;
  ErrorMeter meter_;
  std::vector<PointMeasurement> measured_;
  std::vector<double> block_s_;  // by point: wall time of its first run
};

}  // namespace

std::vector<PointMeasurement> measureInterleaved(const FunctionSet& set, const std::vector<FunctionBlock>& blocks,
                                                 const std::vector<PlotPoint>& points, const InterleaveOptions& options,
                                                 const std::function<void(int64_t done)>& progress) {
  Interleaved interleaved(set, blocks, points);
  int64_t done = 0;
  for (size_t b = 0; b < blocks.size(); ++b) {
    for (size_t p = 0; p < points.size(); ++p) {
      interleaved.measureErrors(p, b);
      progress(++done);
    }
  }
  for (size_t p = 0; p < points.size(); ++p) {
    if (interleaved.isShort(p, options)) interleaved.forgetTimes(p);
  }
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (size_t b = 0; b < blocks.size(); ++b) {
      for (size_t p = 0; p < points.size(); ++p) {
        if (interleaved.isShort(p, options)) interleaved.repeat(p, b);
        progress(++done);
      }
    }
  }
  return interleaved.take();
}

}  // namespace nlg
