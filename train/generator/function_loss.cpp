#include "train/generator/function_loss.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include "runtime_eval/fit/loss_kernel.h"

namespace nlg {
namespace {

struct LossInputs {
  const Representation* representation;
  const TrainingData* data;
  const std::vector<Sample>* samples;
};

// Mean squared error of one sample; gradient is D floats.
float sampleLoss(const LossInputs& inputs, const Sample& sample, const float* theta, float* gradient) {
  const PointOrder& order = pointOrder(*inputs.representation);
  thread_local AlignedFloats phi, mask;
  const int first = order.batch_begin[sample.batch], count = order.batch_begin[sample.batch + 1] - first;
  phi.resize(count);
  mask.resize(count);
  const int valid_count =
      decodeBatch(order, sample.batch, inputs.data->function(sample.function), sample.mirror, phi.data(), mask.data());
  const float scale = valid_count > 0 ? 1.0f / static_cast<float>(valid_count) : 0.0f;
  const double sum = lossAndGradient(*inputs.representation, first, count, phi.data(), mask.data(), theta, gradient);
  for (int i = 0; i < inputs.representation->thetaCount(); ++i) gradient[i] *= scale;
  return static_cast<float>(sum) * scale;
}

class FunctionLoss : public torch::autograd::Function<FunctionLoss> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& theta, int64_t inputs_address) {
    const LossInputs& inputs = *reinterpret_cast<const LossInputs*>(inputs_address);
    const torch::Tensor contiguous = theta.contiguous();
    const auto count = static_cast<int64_t>(inputs.samples->size());
    torch::Tensor losses = torch::empty({count}), gradients = torch::empty({count, contiguous.size(1)});
    const float* theta_values = contiguous.data_ptr<float>();
    float* loss_values = losses.data_ptr<float>();
    float* gradient_values = gradients.data_ptr<float>();
    const int64_t theta_count = contiguous.size(1);
    at::parallel_for(0, count, 8, [&](int64_t begin, int64_t end) {
      for (int64_t b = begin; b < end; ++b) {
        loss_values[b] =
            sampleLoss(inputs, (*inputs.samples)[b], theta_values + b * theta_count, gradient_values + b * theta_count);
      }
    });
    context->save_for_backward({gradients});
    return losses;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list loss_gradients) {
    const torch::Tensor gradients = context->get_saved_variables()[0];
    return {gradients * loss_gradients[0].unsqueeze(1), torch::Tensor()};
  }
};

}  // namespace

torch::Tensor functionLoss(const torch::Tensor& theta, const Representation& representation, const TrainingData& data,
                           const std::vector<Sample>& samples) {
  // the inputs outlive the forward pass, which alone reads them: the backward pass uses the saved gradients
  const LossInputs inputs{&representation, &data, &samples};
  return FunctionLoss::apply(theta, reinterpret_cast<int64_t>(&inputs));
}

}  // namespace nlg
