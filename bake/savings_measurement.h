// What each saving of a bake is worth: the scene baked with and without it.
#pragma once

#include <string>
#include <vector>

#include "bake/savings.h"

namespace nlg {

// What a bake was made from; all of it must outlive the measurement.
struct BakeInputs {
  const BakeScene& scene;
  const std::vector<Generator>& generators;
  const BakeOptions& options;
  std::string spool_folder;
};

// In every round the scene is baked as asked for, once with each saving of the table turned (off where the bake leaves something
// out, on where it does not yet), and as asked for again. Every line that has such a bake gets seconds (the median over the rounds,
// against the mean of the two equal bakes), their noise (the largest distance of two equal bakes of one round), bytes, and the
// difference of the look-ups at places in air; counting is replaced by what was measured.
// Takes 10 to 20 times as long as a bake, more where most probes are in free space; and the spool 9 kB a probe of disk.
//
// statistics   of the bake as asked for
// rounds       >= 1
// savings        as countSavings gives them
// throws       as bakeScene
void measureSavings(const BakeInputs& inputs, const BakeStatistics& statistics, int rounds, std::vector<Saving>* savings);

}  // namespace nlg
