// Makes libtorch compute on the calling threads alone.
#pragma once

namespace nlg {

// From here on every thread that calls libtorch, and through it OpenBLAS, computes alone: training takes several samples at once instead,
// and threads of the libraries' own would only be in the way. Call it before anything else of libtorch.
void computeOnCallingThreads();

}  // namespace nlg
