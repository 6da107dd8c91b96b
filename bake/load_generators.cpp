#include "bake/load_generators.h"

#include <algorithm>

#include "tool/input_file.h"
#include "tool/require_read.h"

namespace nlg {

LoadedGenerators loadGenerators(const std::vector<std::string>& paths) {
  LoadedGenerators loaded;
  OneFileEach given("--weights", "representation");
  for (const std::string& path : paths) {
    Generator generator;
    noteInput(path);
    requireRead(path, Generator::load(path, &generator), "the weights of a generator");
    given.add(path, representationName(generator.representation()));
    const int parameters = generator.representation().thetaCount();
    const auto after = std::find_if(loaded.generators.begin(), loaded.generators.end(),
                                    [&](const Generator& other) { return other.representation().thetaCount() > parameters; });
    loaded.paths.insert(loaded.paths.begin() + (after - loaded.generators.begin()), path);
    loaded.generators.insert(after, std::move(generator));
  }
  return loaded;
}

}  // namespace nlg
