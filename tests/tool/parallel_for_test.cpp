#include "tool/parallel_for.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include "tool/error.h"

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

TEST(ParallelForBlocks, CoversEveryItemOnceInBlocksOfNeighbours) {
  for (const uint64_t count : {uint64_t{0}, uint64_t{1}, uint64_t{63}, uint64_t{64}, uint64_t{1000}}) {
    std::vector<std::atomic<int>> runs(count);
    parallelForBlocks(count, 64, 3, [&](uint64_t first, uint64_t end, int thread) {
      ASSERT_TRUE(thread >= 0 && thread < 3) << thread;
      EXPECT_EQ(first % 64, 0u);
      EXPECT_EQ(end, std::min<uint64_t>(first + 64, count));
      for (uint64_t i = first; i < end; ++i) ++runs[i];
    });
    for (uint64_t i = 0; i < count; ++i) EXPECT_EQ(runs[i], 1) << "item " << i << " of " << count;
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

// Every thread would take a stack that no address space holds, which the system answers as it answers one thread too many.
class RefusedThreads {
 public:
  RefusedThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t huge;
    pthread_attr_init(&huge);
    pthread_attr_setstacksize(&huge, size_t{1} << 48);
    pthread_setattr_default_np(&huge);
    pthread_attr_destroy(&huge);
  }
  ~RefusedThreads() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }

 private:
  pthread_attr_t before_;
};

TEST(ParallelFor, BeginsNothingWhenAThreadIsRefused) {
  std::atomic<int> begun{0};
  const RefusedThreads refused;
  try {
    parallelFor(1000, 4, [&](uint64_t, int) { ++begun; });
    FAIL() << "threads were made";
  } catch (const ThreadError& error) {
    EXPECT_EQ(error.exitCode(), ExitCode::internal_error);
    EXPECT_NE(std::string(error.what()).find("expected 3 more, got 0"), std::string::npos) << error.what();
  }
  EXPECT_EQ(begun, 0);
  parallelFor(1000, 1, [&](uint64_t, int) { ++begun; });
  EXPECT_EQ(begun, 1000) << "what needs no other thread runs";
}

TEST(Threads, EndBeforeWhatTheFirstOneThrowsGoesOn) {
  std::atomic<int> ended{0};
  EXPECT_THROW(onThreads(4,
                         [&](int thread) {
                           if (thread == 0) throw std::runtime_error("the first");
                           ++ended;
                         }),
               std::runtime_error);
  EXPECT_EQ(ended, 3);
}

}  // namespace
}  // namespace nlg
