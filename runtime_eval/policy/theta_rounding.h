// Rounds theta to the light grid's precision, in the best of several ways if one does not pass the check.
#pragma once

#include <memory>

#include "nlg/policy.h"

namespace nlg {

class CodeRounding;
class CompensatedRounding;

struct RoundedTheta {
  Theta theta;
  FunctionCheck check;
};

// One of these a thread: for int8 it holds half a megabyte.
class ThetaRounding {
 public:
  // theta_precision   float16 or int8
  explicit ThetaRounding(const PolicyOptions& options);
  ~ThetaRounding();

  // A number beyond float16 becomes the largest that it has.
  // present   a theta with what the check found of it
  RoundedTheta round(const Representation& representation, const StoredFunction& function, const RoundedTheta& present,
                     const CheckOptions& check);

 private:
  RoundedTheta roundToHalves(const Representation& field, const StoredFunction& function, const Theta& theta,
                             const CheckOptions& check);
  RoundedTheta roundToBytes(const Representation& network, const StoredFunction& function, const RoundedTheta& present,
                            const CheckOptions& check);

  std::unique_ptr<CompensatedRounding> compensated_;  // these two for int8 alone
  std::unique_ptr<CodeRounding> code_;
  FunctionChecker checker_;
};

}  // namespace nlg
