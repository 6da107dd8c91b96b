#include "train/torch_threads.h"

#include <ATen/Parallel.h>
#include <dlfcn.h>

#include <cstdlib>

namespace nlg {

// A thread that is new to libtorch takes the number from the environment. at::set_num_threads would also make a pool of libtorch's own,
// which nothing here uses and which waits for ever for a thread that the system refuses. OpenBLAS, where it is the BLAS, has no other way
// than its own function once it is loaded.
void computeOnCallingThreads() {
  ::setenv("OMP_NUM_THREADS", "1", 1);
  ::unsetenv("MKL_NUM_THREADS");
  at::init_num_threads();
  if (void* set = ::dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) reinterpret_cast<void (*)(int)>(set)(1);
}

}  // namespace nlg
