// Makes the BLAS compute on the calling threads alone.
#pragma once

namespace nlg {

// From here on every thread that calls OpenBLAS, where it is the BLAS, computes alone: our own threads already take one block of work
// each, and results would depend on the machine's number of cores. OpenBLAS ends the process where memory for its threads' jobs gives out.
void computeBlasOnCallingThreads();

}  // namespace nlg
