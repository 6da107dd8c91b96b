// Runs a loop over independent items on several threads. Only this code starts threads, so that a system that refuses one ends
// the tool with one line and leaves no thread behind.
#pragma once

#include <cstdint>
#include <functional>
#include <thread>

namespace nlg {

// As many threads as the machine runs of this process at once, at least 1: processors that it may not use do not count.
int machineThreadCount();

// A thread that runs work, which must not throw. To be joined by its owner.
// throws   ThreadError when the system refuses it
std::thread startThread(const std::function<void()>& work);

// Runs work(thread) once on each of thread_count threads, the calling one among them as number 0, and returns when all are done. No work
// begins before every thread has been made: either all of them run, or none. Of work only that of thread 0 may throw.
// throws   ThreadError when the system refuses a thread; what work(0) throws, when the others are done
void onThreads(int thread_count, const std::function<void(int thread)>& work);

// Nothing when the system lets count more threads live at once, now. For libraries that hang or abort when it does not.
// throws   ThreadError
void requireThreads(int count);

// Runs work(item, thread) for every item in [0, count), each on some thread in [0, thread_count): results must go to places of
// their own, by item or by thread. Items are handed out in order. Returns when all are done; rethrows the first exception, after
// which no further item is begun. thread_count >= 1; with 1 everything runs on the calling thread.
// throws   ThreadError before any item is begun
void parallelFor(uint64_t count, int thread_count, const std::function<void(uint64_t item, int thread)>& work);

// The same of items that are too small to be handed out one by one: work(first, end, thread) for blocks of neighbours, each of block_size
// items but the last. block_size >= 1
void parallelForBlocks(uint64_t count, uint64_t block_size, int thread_count,
                       const std::function<void(uint64_t first, uint64_t end, int thread)>& work);

}  // namespace nlg
