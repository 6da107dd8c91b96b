// What every measurement of functions begins with: held-out functions, or an error that says what is wrong with them.
#pragma once

#include <string>
#include <vector>

#include "datagen/dataset/function_set.h"

namespace nlg {

// The functions of held-out shards, with points that no fit sees.
// throws   InputError as readFunctionSet does; when there is no function at all, when the shards were made without --held-out, or
//          with another pattern of test points than this code's
FunctionSet readHeldOut(const std::vector<std::string>& paths);

}  // namespace nlg
