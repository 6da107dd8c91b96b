#include "train/generator/sample_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr int64_t kWindowItems = kWindowBlocks * kBlockFunctions;

template <class T>
void shuffle(std::vector<T>& values, size_t count, Random random) {
  for (size_t i = count; i > 1; --i) std::swap(values[i - 1], values[random.below(static_cast<uint32_t>(i))]);
}

}  // namespace

WindowedOrder::WindowedOrder(int64_t count, uint64_t seed)
    : count_(count),
      windows_an_epoch_((count + kWindowItems - 1) / kWindowItems),
      seed_(seed),
      block_order_(static_cast<size_t>((count + kBlockFunctions - 1) / kBlockFunctions)) {}

int64_t WindowedOrder::windowOf(int64_t position) const {
  return position / count_ * windows_an_epoch_ + position % count_ / kWindowItems;
}

std::vector<int64_t> WindowedOrder::blocksOf(int64_t window) {
  if (window / windows_an_epoch_ != epoch_) {
    epoch_ = window / windows_an_epoch_;
    std::iota(block_order_.begin(), block_order_.end(), int64_t{0});
    // a block that is not full stays the last one: windows begin at the same positions in every epoch
    shuffle(block_order_, static_cast<size_t>(count_ / kBlockFunctions),
            Random(mixSeed(seed_, 1, static_cast<uint64_t>(epoch_))));
  }
  const auto first = block_order_.begin() + window % windows_an_epoch_ * kWindowBlocks;
  return {first, first + std::min<int64_t>(kWindowBlocks, block_order_.end() - first)};
}

int64_t WindowedOrder::item(int64_t position) {
  const int64_t window = windowOf(position);
  if (window != window_) {
    window_ = window;
    items_.clear();
    for (const int64_t block : blocksOf(window)) {
      const int64_t first = block * kBlockFunctions;
      for (int64_t i = first; i < std::min(first + kBlockFunctions, count_); ++i) items_.push_back(static_cast<uint32_t>(i));
    }
    shuffle(items_, items_.size(), Random(mixSeed(seed_, 2, static_cast<uint64_t>(window))));
  }
  return items_[static_cast<size_t>(position % count_ % kWindowItems)];
}

SampleOrder::SampleOrder(int64_t function_count, std::vector<uint32_t> part, const Options& options)
    : options_(options),
      part_(std::move(part)),
      part_count_(part_.empty() ? 0 : static_cast<int>(std::lround(options.part_share * options.batch))) {
  orders_.emplace_back(function_count, mixSeed(options.seed, 1));
  if (part_count_ > 0) orders_.emplace_back(static_cast<int64_t>(part_.size()), mixSeed(options.seed, 3));
}

std::vector<Sample> SampleOrder::samples(int64_t draw) {
  Random random(mixSeed(options_.seed, 2, static_cast<uint64_t>(draw)));
  const int group_count = options_.point_batch_count / options_.point_batches;
  std::vector<Sample> samples;
  for (int order = 0; order < orderCount(); ++order) {
    for (int64_t position = draw * countOf(order); position < (draw + 1) * countOf(order); ++position) {
      const int64_t item = orders_[order].item(position);
      samples.push_back(
          {order == 0 ? item : int64_t{part_[static_cast<size_t>(item)]}, static_cast<int>(random.below(kMirrorCount)),
           options_.point_batches * static_cast<int>(random.below(static_cast<uint32_t>(group_count))), options_.point_batches});
    }
  }
  return samples;
}

int64_t SampleOrder::firstWindow(int order, int64_t draw) const { return orders_[order].windowOf(draw * countOf(order)); }

int64_t SampleOrder::lastWindow(int order, int64_t draw) const {
  return orders_[order].windowOf(std::max<int64_t>(0, (draw + 1) * countOf(order) - 1));
}

std::vector<int64_t> SampleOrder::functionBlocks(int order, int64_t window) {
  const std::vector<int64_t> blocks = orders_[order].blocksOf(window);
  if (order == 0) return blocks;
  // neighbours in the list of the part are near each other among all functions too
  std::vector<int64_t> function_blocks;
  for (const int64_t block : blocks) {
    const size_t first = static_cast<size_t>(block * kBlockFunctions);
    for (size_t i = first; i < std::min(first + kBlockFunctions, part_.size()); ++i) {
      function_blocks.push_back(part_[i] / kBlockFunctions);
    }
  }
  std::sort(function_blocks.begin(), function_blocks.end());
  function_blocks.erase(std::unique(function_blocks.begin(), function_blocks.end()), function_blocks.end());
  return function_blocks;
}

}  // namespace nlg
