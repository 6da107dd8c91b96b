// Which held-out functions a training set holds already, as they are or mirrored.
//
// Training takes every function in its 8 mirror images (bits as in SupportPattern: point i of mirror m is index m P / 8 + i), so a
// held-out function that equals an image of a training function has been trained on as well. Exact, as DuplicateIndex says.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"

namespace nlg {

// One bit a held-out function, in the order of their set.
struct KnownFunctions {
  std::vector<bool> in_training;           // by the rule, a duplicate of a training function
  std::vector<bool> in_training_mirrored;  // of a training function or of one of its mirror images; holds all of in_training

  uint64_t countInTraining() const;
  uint64_t countInTrainingMirrored() const;
};

// Holds the sketches of all held-out functions in 8 images each (about 1.3 kB a function), and lets training functions pass by.
class KnownFunctionSearch {
 public:
  // held_out   must outlive the search; its points a multiple of 64
  KnownFunctionSearch(const DuplicateRule& rule, const FunctionSet& held_out);
  ~KnownFunctionSearch();
  KnownFunctionSearch(const KnownFunctionSearch&) = delete;
  KnownFunctionSearch& operator=(const KnownFunctionSearch&) = delete;

  // A training function, of as many points as the held-out ones.
  void see(const StoredFunction& training);

  const KnownFunctions& known() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nlg
