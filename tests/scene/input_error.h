// What a call refuses, for tests of readers.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tool/error.h"

namespace nlg {

// The line of the InputError that the call throws; "no error" when it throws none.
template <class Call>
std::string inputErrorOf(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

template <class Call>
void expectInputError(const std::string& words, const Call& call) {
  const std::string error = inputErrorOf(call);
  EXPECT_NE(error.find(words), std::string::npos) << "expected " << words << ", got: " << error;
}

}  // namespace nlg
