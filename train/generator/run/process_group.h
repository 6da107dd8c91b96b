// Processes that train one generator together, each on its part of every batch: libtorch's c10d over Gloo.
#pragma once

#include <torch/types.h>

#include <memory>
#include <string>

namespace nlg {

class ProcessGroup {
 public:
  struct Options {
    int rank = 0;
    int count = 1;
    std::string rendezvous;  // a file that all of them can write, and that no earlier run has used
    int timeout_s = 600;     // the longest wait for another process; longer than a validation takes
  };

  ProcessGroup() = default;  // one process by itself
  // Returns when all processes have found each other.
  // throws   InputError naming the rendezvous file when they do not in time
  explicit ProcessGroup(const Options& options);

  int rank() const { return options_.rank; }
  int count() const { return options_.count; }

  // Replaces a contiguous tensor by its sum over all processes: the same bits in each of them. One process: nothing happens.
  // throws   InputError naming the rendezvous file when another process is gone, or did not come in time
  void sum(torch::Tensor& values) const;

 private:
  struct Impl;
  Options options_;
  std::shared_ptr<Impl> impl_;
};

}  // namespace nlg
