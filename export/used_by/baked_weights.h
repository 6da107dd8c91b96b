// Which weights a bake was made with and which of them its functions use: read from the light grid, or from the bake's report.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace nlg {

struct BakedWeights {
  std::string scene;
  std::map<std::string, std::string> sha256;  // by representation: the weights that the bake was given
  std::vector<std::string> used;              // representations that some function of the light grid has; each is in sha256
};

// path     a light grid (.safetensors), or the line of JSON that nlg-bake prints (.json)
// throws   InputError when it cannot be read, is neither, or does not say which weights it was made with
BakedWeights readBakedWeights(const std::string& path);

}  // namespace nlg
