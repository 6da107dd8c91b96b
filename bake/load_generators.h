// Finds the supplied weights, and loads generators.
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

// Where shipped weights may lie, in the order in which they are looked for: the folder of the environment variable NLG_WEIGHTS and
// no other when it is set; otherwise share/neural-light-grid/weights of the installation that this program belongs to. A build folder
// has a link to the weights of its sources there.
std::vector<std::string> weightsFolders();

// NAME.safetensors of every representation, all from the first folder that has any of them.
//
// representations   names (kRepresentationNames), at least one
// folders           as weightsFolders() gives them
// returns           paths, in the order of the names
// throws            UsageError that says where was looked for what: on an unknown name, when no folder has any of the files, and when
//                   the first that has one lacks another
std::vector<std::string> shippedWeights(const std::vector<std::string>& representations, const std::vector<std::string>& folders);

}  // namespace nlg
