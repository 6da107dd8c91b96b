#include "train/generator/window_loader.h"

#include <algorithm>

#include "tool/parallel_for.h"

namespace nlg {

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
