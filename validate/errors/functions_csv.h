// functions.csv: one line a function and word.
#pragma once

#include <sstream>
#include <string>

#include "validate/errors/measured_word.h"

namespace nlg {

class FunctionsCsv {
 public:
  // Both must outlive it.
  FunctionsCsv(const FunctionSet& set, const Populations& populations);

  // representation   "tent" for the bare tent, which is of none
  void add(const std::string& representation, const MeasuredWord& word);
  std::string text() const { return text_.str(); }

 private:
  const FunctionSet& set_;
  const Populations& populations_;
  std::ostringstream text_;
};

}  // namespace nlg
