#include "train/generator/run/process_group.h"

#include <torch/csrc/distributed/c10d/FileStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>

#include <chrono>
#include <cstdlib>
#include <exception>

#include "tool/error.h"

namespace nlg {

struct ProcessGroup::Impl {
  c10::intrusive_ptr<c10d::ProcessGroupGloo> gloo;
};

namespace {

[[noreturn]] void fail(const ProcessGroup::Options& options, const std::exception& error) {
  const std::string text = error.what();
  throw InputError(options.rendezvous, "process " + std::to_string(options.rank) + " of " + std::to_string(options.count),
                   "all processes within " + std::to_string(options.timeout_s) + " s", text.substr(0, text.find('\n')));
}

std::shared_ptr<::gloo::transport::Device> networkDevice() {
  // the name that every program around c10d reads
  if (const char* name = std::getenv("GLOO_SOCKET_IFNAME")) return c10d::ProcessGroupGloo::createDeviceForInterface(name);
  return c10d::ProcessGroupGloo::createDefaultDevice();
}

}  // namespace

ProcessGroup::ProcessGroup(const Options& options) : options_(options) {
  if (options.count == 1) return;
  impl_ = std::make_shared<Impl>();
  try {
    const std::chrono::milliseconds timeout = std::chrono::seconds(options.timeout_s);
    auto store = c10::make_intrusive<c10d::FileStore>(options.rendezvous, options.count);
    store->setTimeout(timeout);
    auto gloo_options = c10d::ProcessGroupGloo::Options::create(timeout);
    gloo_options->devices.push_back(networkDevice());
    impl_->gloo = c10::make_intrusive<c10d::ProcessGroupGloo>(store, options.rank, options.count, gloo_options);
  } catch (const std::exception& error) {
    fail(options, error);
  }
}

void ProcessGroup::sum(torch::Tensor& values) const {
  if (!impl_) return;
  try {
    std::vector<torch::Tensor> tensors = {values};
    impl_->gloo->allreduce(tensors)->wait();
  } catch (const std::exception& error) {
    fail(options_, error);
  }
}

}  // namespace nlg
