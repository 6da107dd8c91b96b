// How likely chance alone makes a difference between two runs, and which of many differences are more than chance.
#pragma once

#include <cstdint>
#include <vector>

namespace nlg {

// The chance that |T| >= |t|, T of Student's t distribution; to 1e-6 or better. t = 0: 1; t infinite: 0.
// degrees_of_freedom   > 0
double studentChance(double t, double degrees_of_freedom);

// Sign test: the chance that of risen + fallen changes, each up or down alike, so many or more go the way that most went.
// Two-sided, exact. Nothing changed: 1.
double signChance(uint64_t risen, uint64_t fallen);

// Holm's method: which of many figures changed, so that noise alone makes one or more of them pass with at most this chance, however
// they depend on each other. The smallest chance must not exceed level / N, the next level / (N - 1), and so on to the first that
// does; it and all larger ones are noise. S. Holm, A simple sequentially rejective multiple test procedure, 1979.
//
// chances   N, in [0, 1]
// level     in (0, 1)
std::vector<bool> beyondChance(const std::vector<double>& chances, double level);

}  // namespace nlg
