// A damaged file is refused: what disks and transfers do to bytes, the same for every reader.
//
// Only a digest tells numbers from other numbers, so this is for readers of files that have one. Bytes that were made to harm are
// for tests/fuzz, whole tools for the fault injection.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace nlg {

// What a reader says of these bytes, in one line; empty where it takes them.
using SaidOf = std::function<std::string(const std::string& bytes)>;

// The whole bytes are taken. Refused, with a reason, are they cut short, with a byte too many, with a flipped bit, and with zeros
// that became ones, which a sum of words modulo 2^16 - 1 does not see.
//
// step   every so many bytes are they cut and is a bit flipped: 1 where a reader is quick
inline void expectDamageIsRefused(const std::string& whole, const SaidOf& said_of, size_t step = 1) {
  EXPECT_EQ(said_of(whole), "");
  const auto expectRefused = [&](const std::string& damaged, const std::string& what) {
    const std::string said = said_of(damaged);
    ASSERT_FALSE(said.empty()) << what << " of " << whole.size() << " bytes";
    EXPECT_EQ(said.find('\n'), std::string::npos) << what << ": " << said;
  };
  for (size_t at = 0; at < whole.size(); at += step) {
    expectRefused(whole.substr(0, at), "cut to " + std::to_string(at));
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1 << at / step % 8);
    expectRefused(damaged, "a bit of byte " + std::to_string(at));
  }
  expectRefused(whole.substr(0, whole.size() - 1), "a byte less");
  expectRefused(whole + '\0', "a byte more");
  if (const size_t zeros = whole.rfind(std::string(4, '\0')); zeros != std::string::npos)
    expectRefused(std::string(whole).replace(zeros, 2, "\xff\xff"), "ones at " + std::to_string(zeros));
}

}  // namespace nlg
