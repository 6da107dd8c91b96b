// The bakes of --weights, and the methods that they are compared with.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bake/bake_options.h"
#include "bake/prepared_scene.h"
#include "light/methods/method_set.h"
#include "render/picture/image.h"

namespace nlg {

// A bake's generators by its name: "tent_mlp", "pf3 or pf5".
using GeneratorSets = std::vector<std::pair<std::string, std::vector<Generator>>>;

// weights   each a bake: one file, or several with commas between them, of which the bake chooses
// hashes    receives "weights of REPRESENTATION" → SHA-256
// throws    as loadGenerators does
GeneratorSets loadSets(const std::vector<std::string>& weights, std::map<std::string, std::string>* hashes);

// All files that are named so.
std::vector<std::string> weightsPaths(const std::vector<std::string>& weights);

// Of methods that keep light as the bake does.
// probe   rays of every probe
MethodSetOptions methodSetOptions(const BakeOptions& options, const GatherOptions& probe, size_t place_count, int thread_count);

// Writes NAME.png into the folder of --pictures, unless others have one there.
// command   "nlg-validate light"
// returns   the picture's path as the result names it: from the result's own folder
std::string writePicture(const Image& image, const std::string& folder, const std::string& name, const std::string& result_path,
                         const std::string& command);

// "pf3 or pf5" as a part of a file's name: pf3-or-pf5.
std::string fileWord(std::string text);

}  // namespace nlg
