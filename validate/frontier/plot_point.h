// One point of the plot of error against run time: a method with all its settings.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime_eval/evaluator/representation.h"
#include "validate/frontier/function_block.h"

namespace nlg {

// What a method made of one function.
struct FittedFunction {
  Representation representation;
  Theta theta;
  double elapsed_us = 0.0;  // processor time of the thread; of what runs in batches, its share of the batch
};

struct PlotPoint {
  std::string representation;   // a name of kRepresentationNames; of a choice, those that it chose from, joined by "+"
  std::string family;           // docs/reference/formats.md, frontier.json
  std::optional<int> budget;    // what grows along the family: steps, coefficients, bits, threads
  std::string label;            // "generator + 4 LM"
  bool may_be_on_front = true;  // false where the time is not that of one thread
  // theta of every function of a block, in its order, and the time that each took. The same theta every time.
  std::function<std::vector<FittedFunction>(const FunctionBlock&)> run;
};

}  // namespace nlg
