// Random order in which a scene's probes are visited.
#pragma once

#include <cstdint>

namespace nlg {

// A fixed pseudo-random order of [0, count), visited by repeated calls: a prefix of it is a fair sample of all.
// Walks a linear congruence of full period over the next power of two, so that it takes no memory.
class ShuffledOrder {
 public:
  ShuffledOrder(uint64_t count, uint64_t seed);
  bool next(uint64_t* index);  // false when all have been visited

 private:
  uint64_t count_, mask_, multiplier_, increment_, state_, visited_ = 0;
};

}  // namespace nlg
