#include "tool/parallel_for.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace nlg {

int machineThreadCount() {
  // hardware_concurrency() counts what is plugged in; a batch system or a container leaves a process only some of it
  cpu_set_t usable;
  if (sched_getaffinity(0, sizeof usable, &usable) == 0) return std::max(1, CPU_COUNT(&usable));
  // more processors than the set holds
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallelFor(uint64_t count, int thread_count, const std::function<void(uint64_t item, int thread)>& work) {
  std::atomic<uint64_t> next{0};
  std::mutex mutex;
  std::exception_ptr error;
  const auto run = [&](int thread) {
    try {
      for (uint64_t item = next++; item < count; item = next++) work(item, thread);
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  std::vector<std::jthread> threads;
  for (int t = 1; t < thread_count && static_cast<uint64_t>(t) < count; ++t) threads.emplace_back(run, t);
  run(0);
  threads.clear();
  if (error) std::rethrow_exception(error);
}

}  // namespace nlg
