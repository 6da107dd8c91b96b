// Weighting functions solved for, together with the probes' lighting: the talk's "weighting functions can be solved for".
//
// Minimised over probe values L and functions φ >= 0, sampled at the points, with w = φ / Σ_p φ (docs/lab/weighting_functions.md):
//
//   mean over points and signals of (Σ_p w_p(x) L_p − E(x))²  +  smoothness · mean over points of |∇w|²
//   +  anchor · mean over probes of (L_p − E(x_p))²
//
// where the slope is that to the points' neighbours which they see, and a probe that is not around a neighbour counts as
// weight 0 there: functions end continuously where their support ends. Nothing in the first term knows of geometry. The last
// one says that a probe holds the lighting where it stands, nearly: without it the slopes flatten the functions without end,
// and exaggerated probes make up for that.
#pragma once

#include "validate/solved/blend.h"

namespace nlg {

struct SolveOptions {
  int steps = 120;
  double rate = 0.03;        // of Adam, falling to 0 as a half cosine
  double smoothness = 1e-2;  // square metres
  double anchor = 0.1;       // weight of the error at the probes themselves
};

// The function that is minimised. Points that are held out do not enter it.
class JointProblem {
 public:
  // All three must outlive this object.
  JointProblem(const SamplePoints& points, const PointLinks& links, const Signals& signals, const SolveOptions& options);

  // phi       N x 8, >= 0, with a positive sum at every point that is not held out
  // probes    probes x S
  // by_phi, by_probes   receive the gradient, 0 for functions at test points and at probes; either may be null
  // returns   the value
  double evaluate(const BlendWeights& phi, const std::vector<float>& probes, BlendWeights* by_phi,
                  std::vector<float>* by_probes) const;

  // The probes that minimise it for these functions.
  std::vector<float> bestProbes(const BlendWeights& phi) const;

 private:
  struct Slope {
    uint32_t a, b;
    float weight;                             // of the squared difference
    std::array<int8_t, kCornerCount> corner;  // of b that is the same probe as this one of a; -1: none
  };
  double addLight(const BlendWeights& w, const std::vector<float>& probes, BlendWeights* by_w,
                  std::vector<float>* by_probes) const;
  double addSlopes(const BlendWeights& w, BlendWeights* by_w) const;

  const SamplePoints& points_;
  const Signals& signals_;
  std::vector<float> counts_;  // of each point in the mean over points; 0 for test points, and the anchor's for probes
  size_t used_count_ = 0;      // points that are not held out, and no probe's
  std::vector<Slope> slopes_;
};

struct SolvedFunctions {
  BlendWeights weights;  // N x 8, normalised; at test points carried over from the neighbours that they see
  double loss = 0.0;
};

// Starts from the bare tent, which knows no walls; φ moves by Adam, projected to φ >= 0, and L is the best one at every step.
SolvedFunctions solveFunctions(const SamplePoints& points, const PointLinks& links, const Signals& signals,
                               const SolveOptions& options);

}  // namespace nlg
