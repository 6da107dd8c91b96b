// Chooses the functions of each training step: random enough to train on, close enough together to be read from disk.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "train/generator/data/function_cache.h"

namespace nlg {

// One sample of a training step: which function, mirrored how, judged on which batches of its points (point_order.h).
struct Sample {
  int64_t function = 0;
  int mirror = 0;
  int batch = 0;                 // the first of them
  int batch_count = 1;           // neighbours
  bool visibility_only = false;  // a generator of samples reads what the probe sees, in place of phi
};

// Blocks a window: so many functions are shuffled among each other, and lie in memory together.
inline constexpr int64_t kWindowBlocks = 16;

// An endless random order of `count` items, a pure function of (seed, position). Every epoch takes each item once: blocks of
// kBlockFunctions neighbours in a fresh random order, the items of every kWindowBlocks blocks shuffled among each other.
class WindowedOrder {
 public:
  // count >= 1
  WindowedOrder(int64_t count, uint64_t seed);

  int64_t item(int64_t position);
  // Windows are numbered through all epochs.
  int64_t windowOf(int64_t position) const;
  // The blocks of items that a window takes from, in the order of reading.
  std::vector<int64_t> blocksOf(int64_t window);

 private:
  int64_t count_, windows_an_epoch_;
  uint64_t seed_;
  int64_t epoch_ = -1, window_ = -1;  // of what follows
  std::vector<int64_t> block_order_;
  std::vector<uint32_t> items_;
};

// The samples of any draw, a pure function of (seed, draw): a resumed run draws what an uninterrupted one would have. Step s of a
// run that never went back is draw s. Mirror and batch of points are drawn for each sample.
class SampleOrder {
 public:
  struct Options {
    int batch = 256;                // samples a draw
    int point_batch_count = 1;      // batches of points that there are to draw from
    int point_batches = 1;          // of them a sample is judged on; a divisor of point_batch_count
    double visibility_share = 0.0;  // of samples that show visibility only
    double part_share = 0.0;  // of every batch, rounded to whole samples: from an order of their own over a part of the functions
    uint64_t seed = 1;
  };

  // part   indices of the functions that part_share is drawn from, rising; when there are none, nothing is
  SampleOrder(int64_t function_count, std::vector<uint32_t> part, const Options& options);

  std::vector<Sample> samples(int64_t draw);
  int partCount() const { return part_count_; }  // of a batch

  // What has to lie in memory: the samples come from one or two orders (all functions, the part), each with windows.
  int orderCount() const { return part_count_ > 0 ? 2 : 1; }
  int64_t firstWindow(int order, int64_t draw) const;
  int64_t lastWindow(int order, int64_t draw) const;
  std::vector<int64_t> functionBlocks(int order, int64_t window);  // blocks of functions, rising for the part

 private:
  int64_t countOf(int order) const { return order == 0 ? options_.batch - part_count_ : part_count_; }

  Options options_;
  std::vector<uint32_t> part_;
  int part_count_;
  std::vector<WindowedOrder> orders_;
};

// Reads the functions of coming steps from a cache: a thread that keeps one window more in memory than the steps at work need. What is read does not change what is drawn.
class WindowLoader {
 public:
  // cache        outlives the loader, and is loaded by no other one meanwhile
  // first_draw   no earlier draw is going to be required
  // throws       ThreadError when the system refuses the thread
  WindowLoader(FunctionCache& cache, const SampleOrder& order, int64_t first_draw);
  ~WindowLoader();
  WindowLoader(const WindowLoader&) = delete;
  WindowLoader& operator=(const WindowLoader&) = delete;

  // Returns when the functions of a draw lie in memory and have been checked. Draws must not fall.
  // throws   InputError when a block is damaged; whatever else the thread ended with
  void require(int64_t draw);

 private:
  void run();
  bool loadNext(std::unique_lock<std::mutex>& lock);

  FunctionCache& cache_;
  SampleOrder order_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<int64_t> next_, wanted_;  // by order: the first window that is not loaded, the last one that shall be
  std::exception_ptr error_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace nlg
