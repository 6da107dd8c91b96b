#include "datagen/probes/shuffled_order.h"

#include "runtime_eval/numbers/random.h"

namespace nlg {

ShuffledOrder::ShuffledOrder(uint64_t count, uint64_t seed) : count_(count), mask_(0) {
  while (mask_ + 1 < count) mask_ = 2 * mask_ + 1;
  Random random(mixSeed(seed, 0x6f72646572));
  // full period modulo a power of two: increment odd, multiplier 1 modulo 4 (Hull & Dobell 1962)
  multiplier_ = (uint64_t{random.next()} << 3 | 5) & (mask_ | 7);
  increment_ = (uint64_t{random.next()} << 32 | random.next()) | 1;
  state_ = (uint64_t{random.next()} << 32 | random.next()) & mask_;
}

bool ShuffledOrder::next(uint64_t* index) {
  if (visited_ == count_) return false;
  do state_ = (state_ * multiplier_ + increment_) & mask_;
  while (state_ >= count_);
  ++visited_;
  *index = state_;
  return true;
}

}  // namespace nlg
