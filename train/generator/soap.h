// Experiment: SOAP (Adam in the eigenbasis of Shampoo's preconditioner).
#pragma once
#include <torch/linalg.h>
#include <torch/nn.h>
#include <cstdio>
#include <cstdlib>
namespace nlg {
class Soap {
 public:
  int frequency = 20;
  double b1 = 0.95, b2 = 0.99, bs = 0.98;
  int64_t step_ = 0;
  struct State {
    torch::Tensor L, R, QL, QR, m, v;
  };
  std::vector<State> states;
  void step(const std::vector<torch::Tensor>& parameters, double rate) {
    torch::NoGradGuard guard;
    if (states.empty()) states.resize(parameters.size());
    ++step_;
    for (size_t i = 0; i < parameters.size(); ++i) {
      torch::Tensor p = parameters[i];
      if (!p.grad().defined()) continue;
      torch::Tensor g = p.grad();
      State& s = states[i];
      const bool matrix = p.dim() == 2 && p.size(0) > 1 && p.size(1) > 1;
      if (!s.m.defined()) {
        s.m = torch::zeros_like(g);
        s.v = torch::zeros_like(g);
        if (matrix) {
          s.L = torch::mm(g, g.t());
          s.R = torch::mm(g.t(), g);
          s.QL = std::get<1>(torch::linalg::eigh(s.L + 1e-12f * torch::eye(s.L.size(0)), "L")).flip({1}).contiguous();
          s.QR = std::get<1>(torch::linalg::eigh(s.R + 1e-12f * torch::eye(s.R.size(0)), "L")).flip({1}).contiguous();
          continue;
        }
      }
      torch::Tensor h = matrix ? torch::mm(torch::mm(s.QL.t(), g), s.QR) : g;
      s.m.mul_(b1).add_(h, 1 - b1);
      s.v.mul_(b2).addcmul_(h, h, 1 - b2);
      const double c1 = 1 - std::pow(b1, step_), c2 = 1 - std::pow(b2, step_);
      torch::Tensor u = (s.m / c1) / ((s.v / c2).sqrt() + 1e-8);
      if (matrix) u = torch::mm(torch::mm(s.QL, u), s.QR.t());
      p.add_(u, -rate);
      if (!matrix) continue;
      s.L.mul_(bs).add_(torch::mm(g, g.t()), 1 - bs);
      s.R.mul_(bs).add_(torch::mm(g.t(), g), 1 - bs);
      if (step_ == 2 || step_ % frequency == static_cast<int64_t>(i) % frequency) {
        torch::Tensor m = torch::mm(torch::mm(s.QL, s.m), s.QR.t());
        for (int side = 0; side < 2; ++side) {
          torch::Tensor& Q = side == 0 ? s.QL : s.QR;
          torch::Tensor& M = side == 0 ? s.L : s.R;
          torch::Tensor MQ = torch::mm(M, Q);
          torch::Tensor order = std::get<1>((Q * MQ).sum(0).sort(-1, true));
          MQ = MQ.index_select(1, order);
          s.v = s.v.index_select(side, order);
          Q = std::get<0>(torch::linalg::qr(MQ, "reduced")).contiguous();
        }
        s.m = torch::mm(torch::mm(s.QL.t(), m), s.QR);
      }
    }
  }
};
}  // namespace nlg
