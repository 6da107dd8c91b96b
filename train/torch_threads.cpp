#include "train/torch_threads.h"

#include <ATen/Parallel.h>

#include <cstdlib>

#include "train/blas_threads.h"

namespace nlg {

// A thread that is new to libtorch takes the number from the environment. at::set_num_threads would also make a pool of libtorch's own,
// which nothing here uses and which waits for ever for a thread that the system refuses.
void computeOnCallingThreads() {
  ::setenv("OMP_NUM_THREADS", "1", 1);
  ::unsetenv("MKL_NUM_THREADS");
  at::init_num_threads();
  computeBlasOnCallingThreads();
}

}  // namespace nlg
