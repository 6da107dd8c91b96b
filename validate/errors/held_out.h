// What every measurement begins with: held-out functions and exported generators, or an error that says what is wrong with them.
#pragma once

#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"
#include "runtime_eval/evaluator/generator.h"

namespace nlg {

// The functions of held-out shards, with points that no fit sees.
// throws   InputError as readFunctionSet does; when there is no function at all, when the shards were made without --held-out, or
//          with another pattern of test points than this code's
FunctionSet readHeldOut(const std::vector<std::string>& paths);

// throws   InputError naming the file and what the reader says of it
Generator loadGenerator(const std::string& path);
// loadGenerator's refusals; a generator's numbers, from which generators of other settings are made.
GeneratorData loadGeneratorData(const std::string& path);

}  // namespace nlg
