// Blocks of neighbours in the cache are drawn into windows, and functions are shuffled within a window:
// a window is read from the disk while the one before it trains.
#include "train/generator/data/sample_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"

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
  // a part of each draw comes from all functions, the rest from those that take a theta
  for (int order = 0; order < orderCount(); ++order) {
    for (int64_t position = draw * countOf(order); position < (draw + 1) * countOf(order); ++position) {
      const int64_t item = orders_[order].item(position);
      samples.push_back(
          {order == 0 ? item : int64_t{part_[static_cast<size_t>(item)]}, static_cast<int>(random.below(kMirrorCount)),
           options_.point_batches * static_cast<int>(random.below(static_cast<uint32_t>(group_count))), options_.point_batches});
    }
  }
  Random visibility(mixSeed(options_.seed, 4, static_cast<uint64_t>(draw)));
  for (Sample& sample : samples) sample.visibility_only = visibility.uniform(0.0, 1.0) < options_.visibility_share;
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

WindowLoader::WindowLoader(FunctionCache& cache, const SampleOrder& order, int64_t first_draw) : cache_(cache), order_(order) {
  for (int o = 0; o < order_.orderCount(); ++o) {
    next_.push_back(order_.firstWindow(o, first_draw));
    wanted_.push_back(next_.back());
  }
  thread_ = startThread([this] { run(); });
}

WindowLoader::~WindowLoader() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void WindowLoader::require(int64_t draw) {
  std::unique_lock lock(mutex_);
  const auto loaded = [&] {
    for (int o = 0; o < order_.orderCount(); ++o) {
      if (next_[o] <= order_.lastWindow(o, draw)) return false;
    }
    return true;
  };
  for (int o = 0; o < order_.orderCount(); ++o) {
    // a run that went back leaves windows out
    next_[o] = std::max(next_[o], order_.firstWindow(o, draw));
    wanted_[o] = std::max(wanted_[o], order_.lastWindow(o, draw) + 1);
  }
  changed_.notify_all();
  changed_.wait(lock, [&] { return error_ || loaded(); });
  if (error_) std::rethrow_exception(error_);
}

// Loads one window; false when there is nothing to load.
bool WindowLoader::loadNext(std::unique_lock<std::mutex>& lock) {
  for (int o = 0; o < order_.orderCount(); ++o) {
    if (next_[o] > wanted_[o]) continue;
    const int64_t window = next_[o];
    const std::vector<int64_t> blocks = order_.functionBlocks(o, window);
    lock.unlock();
    for (const int64_t block : blocks) cache_.adviseBlock(block);
    for (const int64_t block : blocks) cache_.loadBlock(block);
    lock.lock();
    next_[o] = std::max(next_[o], window + 1);
    return true;
  }
  return false;
}

void WindowLoader::run() {
  std::unique_lock lock(mutex_);
  try {
    while (!stopping_) {
      if (loadNext(lock))
        changed_.notify_all();
      else
        changed_.wait(lock);
    }
  } catch (...) {
    // a read throws without the lock, what allocates before it throws with it
    if (!lock.owns_lock()) lock.lock();
    error_ = std::current_exception();
    changed_.notify_all();
  }
}

}  // namespace nlg
