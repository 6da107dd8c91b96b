#include "tool/parallel_for.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace nlg {
namespace {

TEST(ParallelFor, RunsEveryItemOnceOnItsThreads) {
  for (const int threads : {1, 2, 7}) {
    for (const uint64_t count : {uint64_t{0}, uint64_t{1}, uint64_t{5}, uint64_t{1000}}) {
      std::vector<std::atomic<int>> runs(count);
      parallelFor(count, threads, [&](uint64_t item, int thread) {
        ASSERT_TRUE(thread >= 0 && thread < threads) << thread;
        ++runs[item];
      });
      for (uint64_t i = 0; i < count; ++i) EXPECT_EQ(runs[i], 1) << "item " << i << ", " << threads << " threads";
    }
  }
}

TEST(ParallelFor, RethrowsAndStops) {
  for (const int threads : {1, 3}) {
    std::atomic<uint64_t> begun{0};
    EXPECT_THROW(parallelFor(1000000, threads,
                             [&](uint64_t item, int) {
                               ++begun;
                               if (item == 10) throw std::runtime_error("item 10");
                             }),
                 std::runtime_error);
    EXPECT_LT(begun, 1000000u) << threads << " threads";
  }
}

TEST(MachineThreadCount, CountsOnlyProcessorsThatTheProcessMayUse) {
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  EXPECT_EQ(machineThreadCount(), CPU_COUNT(&before));
  CPU_ZERO(&one);
  for (int cpu = 0; CPU_COUNT(&one) == 0; ++cpu) {
    if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &one);
  }
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(machineThreadCount(), 1);
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

}  // namespace
}  // namespace nlg
