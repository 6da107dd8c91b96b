#include "datagen/shards/shard_pipeline.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kBlocksAheadPerThread = 4;  // a slow block holds up nobody before so many others are done

class Run {
 public:
  Run(const ShardPipeline& pipeline, int thread_count, ShardCollector& collector, ShardWriter& writer)
      : pipeline_(pipeline),
        max_blocks_ahead_(kBlocksAheadPerThread * static_cast<uint64_t>(thread_count)),
        collector_(collector),
        writer_(writer) {}

  void work() {
    try {
      const auto generate = pipeline_.makeGenerator();
      std::unique_lock lock(mutex_);
      while (step(lock, generate)) {
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!error_) error_ = std::current_exception();
    }
    changed_.notify_all();
  }

  void finish() {
    if (error_) std::rethrow_exception(error_);
    const FunctionRows rest = collector_.takeRest();
    if (rest.functionCount() > 0) writer_.append(encodeFunctions(rest, 0, rest.functionCount()));
  }

 private:
  using Generate = std::function<void(const std::vector<uint64_t>&, ProbeBlock*)>;

  // Does the most urgent thing there is to do, what lies furthest down the line first; false when all is done.
  bool step(std::unique_lock<std::mutex>& lock, const Generate& generate) {
    if (error_) return false;
    if (!writing_ && encoded_.count(next_written_) != 0) {
      write(lock);
    } else if (!collecting_ && !stopped_ && generated_.count(next_collected_) != 0) {
      collect(lock);
    } else if (!chunks_.empty()) {
      encode(lock);
    } else if (!stopped_ && !exhausted_ && next_block_ < next_collected_ + max_blocks_ahead_) {
      generateBlock(lock, generate);
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

  void generateBlock(std::unique_lock<std::mutex>& lock, const Generate& generate) {
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

  void encode(std::unique_lock<std::mutex>& lock) {
    const auto [number, chunk] = std::move(chunks_.front());
    chunks_.pop_front();
    EncodedFunctions encoded;
    unlocked(lock, [&, &chunk = chunk] { encoded = encodeFunctions(chunk, 0, chunk.functionCount()); });
    encoded_.emplace(number, std::move(encoded));
  }

  void write(std::unique_lock<std::mutex>& lock) {
    writing_ = true;
    const EncodedFunctions encoded = std::move(encoded_.extract(next_written_).mapped());
    unlocked(lock, [&] { writer_.append(encoded); });
    ++next_written_;
    writing_ = false;
  }

  const ShardPipeline& pipeline_;
  const uint64_t max_blocks_ahead_;
  ShardCollector& collector_;
  ShardWriter& writer_;

  std::mutex mutex_;  // guards all that follows
  std::condition_variable changed_;
  std::exception_ptr error_;
  bool stopped_ = false, exhausted_ = false, collecting_ = false, writing_ = false;
  uint64_t next_block_ = 0, next_collected_ = 0, next_chunk_ = 0, next_written_ = 0;
  int at_work_ = 0;
  std::map<uint64_t, ProbeBlock> generated_;
  std::deque<std::pair<uint64_t, FunctionRows>> chunks_;
  std::map<uint64_t, EncodedFunctions> encoded_;
};

}  // namespace

void ShardPipeline::run(int thread_count, ShardCollector& collector, ShardWriter& writer) const {
  Run run(*this, thread_count, collector, writer);
  onThreads(thread_count, [&run](int) { run.work(); });
  run.finish();
}

}  // namespace nlg
