// An adaptive binary range coder, which stores numbers of a few bits in nearly their entropy.
//
// G. N. N. Martin, "Range encoding: an algorithm for removing redundancy from a digitised message" (1979), with the carry of Schindler
// and the bit trees of LZMA. A bit's probability is the mean of two that follow what was coded, one fast and one slowly, and both at
// first as fast as a mean of what was seen. Integers alone: the same bytes on every machine.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace nlg {

// What was seen so far of a bit.
class BitModel {
 public:
  // That it is 0, of kCertain. Both probabilities end some steps before 0 and 1.
  uint32_t zero() const { return (uint32_t{fast_} + slow_) >> 1; }
  void see(int bit) {
    const uint32_t rate = kRates[seen_];
    step(bit, std::max(rate, kFastRate), &fast_);
    step(bit, std::max(rate, kSlowRate), &slow_);
    if (seen_ + 1u < kRates.size()) ++seen_;
  }
  static constexpr int kCertainBits = 15;
  static constexpr uint32_t kCertain = 1u << kCertainBits;

 private:
  static constexpr uint32_t kFastRate = 1u << 12, kSlowRate = 1u << 9;  // of 2^16
  // 1 / (n + 1.6) of 2^16 for the n + 1st time
  static constexpr std::array<uint16_t, 128> kRates = [] {
    std::array<uint16_t, 128> rates{};
    for (uint32_t n = 0; n < rates.size(); ++n) rates[n] = static_cast<uint16_t>(655360u / (10 * n + 16));
    return rates;
  }();
  static void step(int bit, uint32_t rate, uint16_t* zero) {
    const uint32_t before = *zero;
    *zero = static_cast<uint16_t>(bit == 0 ? before + ((kCertain - before) * rate >> 16) : before - (before * rate >> 16));
  }

  uint16_t fast_ = kCertain / 2, slow_ = kCertain / 2;
  uint8_t seen_ = 0;
};

// What was seen so far of numbers of one kind. Each of its bits costs a forty-fourth of itself at least, however sure it is: what is read
// out of some bytes is at most that many times as much, whoever wrote them.
class NumberModel {
 public:
  // bits   of every number, 0 … 16
  explicit NumberModel(int bits) : bits_(bits), tree_(size_t{1} << bits) {}

 private:
  friend class RangeEncoder;
  friend class RangeDecoder;
  static constexpr uint32_t kLeast = BitModel::kCertain / 64;
  uint32_t zero(uint32_t node) const { return std::clamp(tree_[node].zero(), kLeast, BitModel::kCertain - kLeast); }
  int bits_;
  std::vector<BitModel> tree_;  // of the bits above, behind a 1
};

// What was seen so far of numbers around 0: how many bits they have without their sign, the sign, and the two bits behind the highest.
// What lies behind those is as often 0 as 1.
class DifferenceModel {
 public:
  static constexpr int kMostBits = 12;  // of |number|

 private:
  friend class RangeEncoder;
  friend class RangeDecoder;
  static constexpr int kModelled = 2;  // bits behind the highest
  std::array<BitModel, kMostBits> more_;
  BitModel sign_;
  std::array<std::array<BitModel, 1 << kModelled>, kMostBits + 1> behind_;  // by bits: a tree, behind a 1
};

class RangeEncoder {
 public:
  void add(int bit, BitModel* model) {
    addBit(bit, model->zero());
    model->see(bit);
  }

  // number   < 2^bits of the model
  void add(uint32_t number, NumberModel* model) {
    uint32_t node = 1;
    for (int i = model->bits_ - 1; i >= 0; --i) {
      const int bit = static_cast<int>(number >> i & 1);
      addBit(bit, model->zero(node));
      model->tree_[node].see(bit);
      node = 2 * node + static_cast<uint32_t>(bit);
    }
  }

  // By the mean of what two models, which are not the same, say.
  // number   |number| < 2^kMostBits
  void add(int number, DifferenceModel* a, DifferenceModel* b) {
    const auto size = static_cast<uint32_t>(number < 0 ? -number : number);
    const int bits = std::bit_width(size);
    for (int i = 0; i < std::min(bits + 1, DifferenceModel::kMostBits); ++i)
      addOfTwo(i < bits ? 1 : 0, &a->more_[static_cast<size_t>(i)], &b->more_[static_cast<size_t>(i)]);
    if (bits == 0) return;
    addOfTwo(number < 0 ? 1 : 0, &a->sign_, &b->sign_);
    uint32_t node = 1;
    for (int i = bits - 2; i >= 0; --i) {
      const int bit = static_cast<int>(size >> i & 1);
      if (i < bits - 1 - DifferenceModel::kModelled) {
        addBit(bit, BitModel::kCertain / 2);
        continue;
      }
      addOfTwo(bit, &a->behind_[static_cast<size_t>(bits)][node], &b->behind_[static_cast<size_t>(bits)][node]);
      node = 2 * node + static_cast<uint32_t>(bit);
    }
  }

  // The bytes of all numbers. Nothing may be added afterwards.
  std::vector<uint8_t> finish() {
    for (int i = 0; i < 5; ++i) shiftLow();
    return std::move(bytes_);
  }

 private:
  void addOfTwo(int bit, BitModel* a, BitModel* b) {
    addBit(bit, (a->zero() + b->zero()) >> 1);
    a->see(bit);
    b->see(bit);
  }

  // zero   in 1 … kCertain - 1
  void addBit(int bit, uint32_t zero) {
    const uint32_t bound = (range_ >> BitModel::kCertainBits) * zero;
    if (bit == 0) {
      range_ = bound;
    } else {
      low_ += bound;
      range_ -= bound;
    }
    while (range_ < 1u << 24) {
      range_ <<= 8;
      shiftLow();
    }
  }

  // A byte leaves once no carry can reach it.
  void shiftLow() {
    if (low_ < 0xff000000u || low_ > 0xffffffffu) {
      const auto carry = static_cast<uint8_t>(low_ >> 32);
      if (has_first_) bytes_.push_back(static_cast<uint8_t>(first_ + carry));
      for (; waiting_ > 0; --waiting_) bytes_.push_back(static_cast<uint8_t>(0xff + carry));
      first_ = static_cast<uint8_t>(low_ >> 24);
      has_first_ = true;
    } else {
      ++waiting_;
    }
    low_ = (low_ & 0x00ffffff) << 8;
  }

  uint64_t low_ = 0;
  uint32_t range_ = 0xffffffffu;
  uint8_t first_ = 0;
  bool has_first_ = false;
  uint64_t waiting_ = 0;  // bytes of 0xff behind the first
  std::vector<uint8_t> bytes_;
};

// Reads what an encoder wrote, with models that begin as its models began. Other bytes give other numbers, and never a read beyond them.
class RangeDecoder {
 public:
  RangeDecoder(const uint8_t* bytes, size_t count) : bytes_(bytes), count_(count) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | nextByte();
  }

  int next(BitModel* model) {
    const int bit = nextBit(model->zero());
    model->see(bit);
    return bit;
  }

  uint32_t next(NumberModel* model) {
    uint32_t node = 1;
    for (int i = 0; i < model->bits_; ++i) {
      const int bit = nextBit(model->zero(node));
      model->tree_[node].see(bit);
      node = 2 * node + static_cast<uint32_t>(bit);
    }
    return node - (1u << model->bits_);
  }

  // |number| < 2^kMostBits
  int next(DifferenceModel* a, DifferenceModel* b) {
    int bits = 0;
    while (bits < DifferenceModel::kMostBits &&
           nextOfTwo(&a->more_[static_cast<size_t>(bits)], &b->more_[static_cast<size_t>(bits)]) == 1)
      ++bits;
    if (bits == 0) return 0;
    const bool is_negative = nextOfTwo(&a->sign_, &b->sign_) == 1;
    uint32_t node = 1;
    int size = 1;
    for (int i = bits - 2; i >= 0; --i) {
      int bit = 0;
      if (i < bits - 1 - DifferenceModel::kModelled) {
        bit = nextBit(BitModel::kCertain / 2);
      } else {
        bit = nextOfTwo(&a->behind_[static_cast<size_t>(bits)][node], &b->behind_[static_cast<size_t>(bits)][node]);
        node = 2 * node + static_cast<uint32_t>(bit);
      }
      size = 2 * size + bit;
    }
    return is_negative ? -size : size;
  }

  // Whether all numbers were read out of exactly these bytes.
  bool isAtEnd() const { return read_ == count_; }
  // Numbers are being read that no byte says.
  bool isBeyondEnd() const { return read_ > count_; }

 private:
  int nextOfTwo(BitModel* a, BitModel* b) {
    const int bit = nextBit((a->zero() + b->zero()) >> 1);
    a->see(bit);
    b->see(bit);
    return bit;
  }

  int nextBit(uint32_t zero) {
    const uint32_t bound = (range_ >> BitModel::kCertainBits) * zero;
    const int bit = code_ < bound ? 0 : 1;
    if (bit == 0) {
      range_ = bound;
    } else {
      code_ -= bound;
      range_ -= bound;
    }
    while (range_ < 1u << 24) {
      range_ <<= 8;
      code_ = code_ << 8 | nextByte();
    }
    return bit;
  }

  uint32_t nextByte() {
    const uint32_t byte = read_ < count_ ? bytes_[read_] : 0;
    ++read_;
    return byte;
  }

  const uint8_t* bytes_;
  size_t count_, read_ = 0;
  uint32_t range_ = 0xffffffffu, code_ = 0;
};

}  // namespace nlg
