// A loop over independent items on several threads.
#pragma once

#include <cstdint>
#include <functional>

namespace nlg {

// As many threads as the machine runs of this process at once, at least 1: processors that it may not use do not count.
int machineThreadCount();

// Runs work(item, thread) for every item in [0, count), each on some thread in [0, thread_count): results must go to places of
// their own, by item or by thread. Items are handed out in order. Returns when all are done; rethrows the first exception, after
// which no further item is begun. thread_count >= 1; with 1 everything runs on the calling thread.
void parallelFor(uint64_t count, int thread_count, const std::function<void(uint64_t item, int thread)>& work);

}  // namespace nlg
