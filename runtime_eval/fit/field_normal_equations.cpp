#include "runtime_eval/fit/field_normal_equations.h"

#include <algorithm>
#include <vector>

namespace nlg {

void fieldNormalEquations(const PointOrder&, const WeightingFunction&, const float*, NormalEquations*) {}

}  // namespace nlg
