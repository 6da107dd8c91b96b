// Reads the functions of coming training steps from a cache during the present ones.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "train/generator/function_cache.h"
#include "train/generator/sample_order.h"

namespace nlg {

// A thread that keeps one window more in memory than the steps at work need. What is read does not change what is drawn.
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
