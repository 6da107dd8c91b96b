#include "datagen/functions/function_pipeline.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <utility>

#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kBlocksAheadPerThread = 4;  // a slow block holds up nobody before so many others are done

class Run {
 public:
  Run(const FunctionPipeline& pipeline, int thread_count, FunctionCollector& collector)
      : pipeline_(pipeline),
        max_blocks_ahead_(kBlocksAheadPerThread * static_cast<uint64_t>(thread_count)),
        collector_(collector) {}

  void work(int thread) {
    try {
      const Worker worker{pipeline_.makeGenerator(thread), pipeline_.makeFinisher(thread)};
      std::unique_lock lock(mutex_);
      while (step(lock, worker)) {
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!error_) error_ = std::current_exception();
    }
    changed_.notify_all();
  }

  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  struct Worker {
    FunctionPipeline::Generate generate;
    FunctionPipeline::Finish finish;
  };

  // Does the most urgent thing there is to do, what lies furthest down the line first; false when all is done.
  bool step(std::unique_lock<std::mutex>& lock, const Worker& worker) {
    if (error_) return false;
    if (!taking_ && finished_.count(next_taken_) != 0) {
      take(lock);
    } else if (!collecting_ && !stopped_ && generated_.count(next_collected_) != 0) {
      collect(lock);
    } else if (!chunks_.empty()) {
      finish(lock, worker.finish);
    } else if (!stopped_ && !exhausted_ && next_block_ < next_collected_ + max_blocks_ahead_) {
      generateBlock(lock, worker.generate);
    } else if (!rest_taken_ && allCollected()) {
      takeRest();
    } else if (at_work_ == 0) {
      return false;
    } else {
      changed_.wait(lock);
    }
    return true;
  }

  // Runs task without the lock. When it throws, the thread's end reports it; at_work_ no longer matters then.
  template <class Task>
  void unlocked(std::unique_lock<std::mutex>& lock, const Task& task) {
    ++at_work_;
    lock.unlock();
    task();
    lock.lock();
    --at_work_;
    changed_.notify_all();
  }

  void generateBlock(std::unique_lock<std::mutex>& lock, const FunctionPipeline::Generate& generate) {
    const std::vector<uint64_t> probes = pipeline_.nextProbes();
    if (probes.empty()) {
      exhausted_ = true;
      changed_.notify_all();
      return;
    }
    const uint64_t number = next_block_++;
    ProbeBlock block;
    unlocked(lock, [&] { generate(probes, &block); });
    if (!stopped_) generated_.emplace(number, std::move(block));
  }

  void collect(std::unique_lock<std::mutex>& lock) {
    collecting_ = true;
    const ProbeBlock block = std::move(generated_.extract(next_collected_).mapped());
    std::vector<FunctionRows> chunks;
    unlocked(lock, [&] {
      chunks = collector_.add(block);
      if (pipeline_.report) pipeline_.report(collector_);
    });
    for (FunctionRows& chunk : chunks) chunks_.emplace_back(next_chunk_++, std::move(chunk));
    ++next_collected_;
    collecting_ = false;
    if (!collector_.full()) return;
    stopped_ = true;
    generated_.clear();
  }

  bool allCollected() const { return !collecting_ && (stopped_ || (exhausted_ && next_collected_ == next_block_)); }

  void takeRest() {
    rest_taken_ = true;
    FunctionRows rest = collector_.takeRest();
    if (rest.functionCount() > 0) chunks_.emplace_back(next_chunk_++, std::move(rest));
  }

  void finish(std::unique_lock<std::mutex>& lock, const FunctionPipeline::Finish& finish) {
    const auto [number, chunk] = std::move(chunks_.front());
    chunks_.pop_front();
    std::function<void()> finished;
    unlocked(lock, [&, &chunk = chunk] { finished = finish(chunk); });
    finished_.emplace(number, std::move(finished));
  }

  void take(std::unique_lock<std::mutex>& lock) {
    taking_ = true;
    const std::function<void()> finished = std::move(finished_.extract(next_taken_).mapped());
    unlocked(lock, finished);
    ++next_taken_;
    taking_ = false;
  }

  const FunctionPipeline& pipeline_;
  const uint64_t max_blocks_ahead_;
  FunctionCollector& collector_;

  std::mutex mutex_;  // guards all that follows
  std::condition_variable changed_;
  std::exception_ptr error_;
  bool stopped_ = false, exhausted_ = false, collecting_ = false, rest_taken_ = false, taking_ = false;
  uint64_t next_block_ = 0, next_collected_ = 0, next_chunk_ = 0, next_taken_ = 0;
  int at_work_ = 0;
  std::map<uint64_t, ProbeBlock> generated_;
  std::deque<std::pair<uint64_t, FunctionRows>> chunks_;
  std::map<uint64_t, std::function<void()>> finished_;
};

}  // namespace

void FunctionPipeline::run(int thread_count, FunctionCollector& collector) const {
  Run run(*this, thread_count, collector);
  onThreads(thread_count, [&run](int thread) { run.work(thread); });
  run.rethrow();
}

}  // namespace nlg
