// The command `nlg-export used-by`: copies the weights that a light grid uses.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace nlg {

// Which weights a bake was made with and which of them its functions use: read from the light grid, or from the bake's report.
struct BakedWeights {
  std::string scene;
  std::map<std::string, std::string> sha256;  // by representation: the weights that the bake was given
  std::vector<std::string> used;              // representations that some function of the light grid has; each is in sha256
};

// path     a light grid (.safetensors), or the line of JSON that nlg-bake prints (.json)
// throws   InputError when it cannot be read, is neither, or does not say which weights it was made with
BakedWeights readBakedWeights(const std::string& path);

// A weights file and what becomes of it.
struct BakeWeights {
  std::string path, representation, sha256;
  uint64_t bytes = 0;
  bool used = false;
  std::string why;  // it is left out; empty for those that are used
};

// Says of every file whether the bake's functions use it.
//
// bake_path   what `baked` was read from, for messages
// throws      InputError when a file holds no generator, when its representation was baked with other weights, or when a
//             representation that functions use is in none of the files; UsageError when two are of the same representation
std::vector<BakeWeights> weightsUsedBy(const BakedWeights& baked, const std::string& bake_path,
                                       const std::vector<std::string>& paths);

// Copies those that are used to FOLDER/REPRESENTATION.safetensors, byte for byte: where nlg-bake looks for weights when $NLG_WEIGHTS
// is the folder. Without any it makes no folder.
//
// throws   UsageError when a copy would replace one of the inputs, or the folder holds weights of a representation that is left out;
//          InputError when a file is no longer the one that was looked at; OutputError
void copyUsedWeights(const std::vector<BakeWeights>& weights, const std::string& bake_path, const std::string& folder);

// The tool's command `used-by`: nlg-export used-by --bake GRID --weights W1 [W2 …] --out FOLDER.
int usedByMain(int argc, char** argv);

}  // namespace nlg
