// Orders a trained dictionary for bakes: numbers by importance, each with the unit that one step of a byte has.
//
// Any linear change of a code's numbers, undone in the dictionary, leaves every function what it is. Functions of the training set are
// fitted; in the metric of their mean normal equations the principal components of their codes become the new numbers. Then what is left
// out of a code's end costs least, and the mean code is 0. A unit is a 127th of the furthest that a fit went, and some more.
#pragma once

#include "runtime_eval/evaluator/generator/generator_data.h"
#include "train/generator/data/training_data.h"
#include "train/generator/network/generator_network.h"

namespace nlg {

struct CodeOrderingOptions {
  int functions = 4096;      // of the training set, at equal distances, that are fitted
  double tent_rmse = 0.002;  // of those whose bare tent has a larger blend RMSE
  LossOptions loss = CheckOptions().loss();
  int threads = 1;
};

// Changes the last layer, the dictionary and the deviations of a network of codes; what it predicts stays, but for rounding. The same input
// gives the same bytes on any number of threads.
// throws   InputError where the training set has no function to fit
void orderCodes(const TrainingData& training, const BasisData& basis, const CodeOrderingOptions& options,
                GeneratorNetwork* network);

}  // namespace nlg
