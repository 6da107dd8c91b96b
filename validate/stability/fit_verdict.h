// What every fit promises, however stiff its start.
#pragma once

#include "runtime_eval/fit/fit_result.h"

namespace nlg {

// Whether a fit kept its promises: a finite start gives a finite theta that is no worse; any other comes back as it was.
struct FitVerdict {
  bool finite = true, no_worse = true, within_budget = true;
  bool holds() const { return finite && no_worse && within_budget; }
};
FitVerdict judge(const Representation& representation, const WeightingFunction& function, const Theta& start,
                 const FitResult& fit, int budget);

}  // namespace nlg
