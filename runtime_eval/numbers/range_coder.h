// An adaptive binary range coder: numbers of a few bits each, in nearly as many bits as their statistics need.
//
// G. N. N. Martin, "Range encoding: an algorithm for removing redundancy from a digitised message" (1979), with the carry of Schindler
// and the bit trees of LZMA. A bit's probability is the mean of two that follow what was coded, one fast and one slowly. Integers
// alone: the same bytes on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nlg {

// What was seen so far of numbers of one kind.
class NumberModel {
 public:
  // bits   of every number, 0 … 16
  explicit NumberModel(int bits) : bits_(bits), states_(size_t{1} << bits) {}

 private:
  friend class RangeEncoder;
  friend class RangeDecoder;
  static constexpr int kProbabilityBits = 15;
  struct BitState {
    uint16_t fast = 1 << (kProbabilityBits - 1), slow = 1 << (kProbabilityBits - 1);  // that the bit is 0
    // In 1 … 2^15 - 1, as both are between 2^4 and 2^15 - 2^4 or so: their steps end there.
    uint32_t zero() const { return (uint32_t{fast} + slow) >> 1; }
    void see(int bit) {
      constexpr uint32_t kOne = 1u << kProbabilityBits;
      fast = static_cast<uint16_t>(bit == 0 ? fast + ((kOne - fast) >> 4) : fast - (fast >> 4));
      slow = static_cast<uint16_t>(bit == 0 ? slow + ((kOne - slow) >> 7) : slow - (slow >> 7));
    }
  };
  int bits_;
  std::vector<BitState> states_;  // a tree: of the bits above, behind a 1
};

class RangeEncoder {
 public:
  // number   < 2^bits of the model
  void add(uint32_t number, NumberModel* model) {
    uint32_t node = 1;
    for (int i = model->bits_ - 1; i >= 0; --i) {
      const int bit = static_cast<int>(number >> i & 1);
      NumberModel::BitState& state = model->states_[node];
      const uint32_t bound = (range_ >> NumberModel::kProbabilityBits) * state.zero();
      if (bit == 0) {
        range_ = bound;
      } else {
        low_ += bound;
        range_ -= bound;
      }
      state.see(bit);
      node = 2 * node + static_cast<uint32_t>(bit);
      while (range_ < 1u << 24) {
        range_ <<= 8;
        shiftLow();
      }
    }
  }

  // The bytes of all numbers. Nothing may be added afterwards.
  std::vector<uint8_t> finish() {
    for (int i = 0; i < 5; ++i) shiftLow();
    return std::move(bytes_);
  }

 private:
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

  uint32_t next(NumberModel* model) {
    uint32_t node = 1;
    for (int i = 0; i < model->bits_; ++i) {
      NumberModel::BitState& state = model->states_[node];
      const uint32_t bound = (range_ >> NumberModel::kProbabilityBits) * state.zero();
      const int bit = code_ < bound ? 0 : 1;
      if (bit == 0) {
        range_ = bound;
      } else {
        code_ -= bound;
        range_ -= bound;
      }
      state.see(bit);
      node = 2 * node + static_cast<uint32_t>(bit);
      while (range_ < 1u << 24) {
        range_ <<= 8;
        code_ = code_ << 8 | nextByte();
      }
    }
    return node - (1u << model->bits_);
  }

  // Whether all numbers were read out of exactly these bytes.
  bool isAtEnd() const { return read_ == count_; }

 private:
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
