#include "tool/parallel_for.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <vector>

#include "tool/error.h"

namespace nlg {
namespace {

enum class Gate { closed, open, cancelled };

// Starts as many threads as are wanted; each waits until the gate opens, then runs work(thread), or ends when all is called off.
class Team {
 public:
  Team(int first, int count, const std::function<void(int thread)>& work) {
    threads_.reserve(count);
    try {
      for (int t = 0; t < count; ++t) {
        threads_.emplace_back([this, &work, thread = first + t] {
          gate_.wait(Gate::closed);
          if (gate_ == Gate::open) work(thread);
        });
      }
    } catch (const std::system_error& error) {
      const size_t made = threads_.size();
      callOff();
      throw ThreadError(static_cast<int>(made), count, error.code().message());
    } catch (...) {
      callOff();
      throw;
    }
  }
  ~Team() {
    if (gate_ == Gate::closed) callOff();
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  void open() { set(Gate::open); }

 private:
  void set(Gate gate) {
    gate_ = gate;
    gate_.notify_all();
  }
  // whoever waits at the gate must not wait for ever
  void callOff() {
    set(Gate::cancelled);
    threads_.clear();
  }

  std::atomic<Gate> gate_{Gate::closed};
  std::vector<std::jthread> threads_;  // last: joined before the gate goes
};

}  // namespace

int machineThreadCount() {
  // hardware_concurrency() counts what is plugged in; a batch system or a container leaves a process only some of it
  cpu_set_t usable;
  if (sched_getaffinity(0, sizeof usable, &usable) == 0) return std::max(1, CPU_COUNT(&usable));
  // more processors than the set holds
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

std::thread startThread(const std::function<void()>& work) {
  try {
    return std::thread(work);
  } catch (const std::system_error& error) {
    throw ThreadError(0, 1, error.code().message());
  }
}

void onThreads(int thread_count, const std::function<void(int thread)>& work) {
  Team others(1, thread_count - 1, work);
  others.open();
  work(0);
}

void requireThreads(int count) {
  const Team team(0, count, [](int) {});
}

void parallelFor(uint64_t count, int thread_count, const std::function<void(uint64_t item, int thread)>& work) {
  std::atomic<uint64_t> next{0};
  std::mutex mutex;
  std::exception_ptr error;
  const auto run = [&](int thread) {
    try {
      // one counter: whoever is free takes the next item
      for (uint64_t item = next++; item < count; item = next++) work(item, thread);
    } catch (...) {
      // nothing more begins after an error; the first one is thrown
      next = count;
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  onThreads(static_cast<int>(std::clamp<uint64_t>(count, 1, static_cast<uint64_t>(thread_count))), run);
  if (error) std::rethrow_exception(error);
}

void parallelForBlocks(uint64_t count, uint64_t block_size, int thread_count,
                       const std::function<void(uint64_t first, uint64_t end, int thread)>& work) {
  parallelFor((count + block_size - 1) / block_size, thread_count,
              [&](uint64_t block, int thread) { work(block * block_size, std::min((block + 1) * block_size, count), thread); });
}

}  // namespace nlg
