#include "train/generator/torch_threads.h"

#include <ATen/Parallel.h>

#include <cstdlib>
#include <string>

#include "tool/parallel_for.h"

namespace nlg {

// at::set_num_threads also makes libtorch's own pool of threads, which nothing here uses, and waits for ever for one that the system
// refuses; from the environment it takes the number for OpenMP alone. The threads are asked for before: OpenMP would end the process
// with a line of its own.
void setTorchThreads(int count, int others) {
  requireThreads(count - 1 + others);
  ::setenv("OMP_NUM_THREADS", std::to_string(count).c_str(), 1);
  ::unsetenv("MKL_NUM_THREADS");
  at::init_num_threads();
  if (at::get_num_threads() != count) at::set_num_threads(count);
}

}  // namespace nlg
