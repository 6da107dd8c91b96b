// Loads the generators of several weights files.
#pragma once

#include <string>
#include <vector>

#include "nlg/generator.h"

namespace nlg {

// By rising number of parameters, which is the order that a choice between representations reads.
struct LoadedGenerators {
  std::vector<Generator> generators;
  std::vector<std::string> paths;  // by generator
};

// In whatever order the files are named.
// throws   InputError naming a file and what the reader says of it; UsageError when two are of one representation
LoadedGenerators loadGenerators(const std::vector<std::string>& paths);

}  // namespace nlg
