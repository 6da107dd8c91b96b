// What a call refuses.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tool/error.h"

namespace nlg {

// The line of the error that the call throws; "no error" when it throws none.
template <class Error, class Call>
std::string errorOfCall(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

template <class Call>
std::string inputErrorOf(const Call& call) {
  return errorOfCall<InputError>(call);
}

template <class Call>
void expectInputError(const std::string& words, const Call& call) {
  const std::string error = inputErrorOf(call);
  EXPECT_NE(error.find(words), std::string::npos) << "expected " << words << ", got: " << error;
}

}  // namespace nlg
