#include "train/generator/torch_threads.h"

#include <ATen/Parallel.h>

#include <cstdlib>

#include "tool/parallel_for.h"

namespace nlg {

// From the environment libtorch takes the number for every thread that asks it for work; set_num_threads is of one thread alone, and
// makes a pool of libtorch's own, which nothing here uses and which waits for ever for a thread that the system refuses.
void useOneTorchThread(int others) {
  requireThreads(others);
  ::setenv("OMP_NUM_THREADS", "1", 1);
  ::unsetenv("MKL_NUM_THREADS");
  at::init_num_threads();
}

}  // namespace nlg
