#include "train/blas_threads.h"

#include <dlfcn.h>

namespace nlg {

// OpenBLAS reads its environment when it is loaded; afterwards it has no other way than its own function.
void computeBlasOnCallingThreads() {
  if (void* set = ::dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) reinterpret_cast<void (*)(int)>(set)(1);
}

}  // namespace nlg
