// A generator with all that one thread needs to run it on blocks: generating and correcting, each with its time.
#pragma once

#include <memory>

#include "runtime_eval/evaluator/generator.h"
#include "runtime_eval/fit/correction.h"
#include "validate/frontier/plot_point.h"

namespace nlg {

class GeneratorRun {
 public:
  // generator   any number of runs may share one
  explicit GeneratorRun(std::shared_ptr<const Generator> generator, const CorrectionOptions& correction = {});

  const Generator& generator() const { return *generator_; }
  const Representation& representation() const { return generator_->representation(); }
  Corrector& corrector() { return corrector_; }

  // theta of a whole block as the network alone yields it.
  std::vector<FittedFunction> generate(const FunctionBlock& block);
  // … and corrected: all that a bake runs before it refines.
  std::vector<FittedFunction> generateAndCorrect(const FunctionBlock& block);

 private:
  // returns   µs a function
  double generateTheta(const FunctionBlock& block);
  double correctTheta(const FunctionBlock& block);
  std::vector<FittedFunction> fitted(const FunctionBlock& block, double elapsed_us) const;

  std::shared_ptr<const Generator> generator_;
  GeneratorScratch scratch_;
  Corrector corrector_;
  std::vector<float> theta_;  // one block
};

}  // namespace nlg
