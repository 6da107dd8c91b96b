// Fits codes by Levenberg–Marquardt: logits are linear in the code, so that a step is exact except for the sigmoid.
//
// What is minimised is the sum of squared weighed residuals and a prior that pulls every number towards 0, the mean code. The logits are
// not rounded meanwhile (dictionary.h); what rounding makes of a code is measured when the fit has ended.
//
// Four things make few steps, and cheap ones, do (docs/theory/representations.md §9):
// - Only *active* points have a row in the normal equations: those that are wrong or that the sigmoid still moves, some 500 of 8192.
// - Where the sigmoid has shut a point that is wrong, its slope is taken as kappa at least, which falls to 0 over the first steps.
// - The weight of dark points rises to what the function's mask says over the first steps.
// - Cells whose points are all open, or all shut, are left out of a pass once the sigmoid agrees; two neighbouring active points of a cell
//   share a row.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime_eval/fit/fit_result.h"

namespace nlg {

struct CodeFitOptions {
  int iterations = 12;
  double damping = 0.1;              // at the start, relative to the diagonal of the equations
  double prior = 1e-3;               // of the square of a number over its deviation, beside the sum over points
  double progress_tolerance = 1e-3;  // ends when two accepted steps in a row lower what is minimised by less than this share
  bool is_ramped = true;             // kappa falls, and the weight of dark points rises, over the first steps
  // No point is left out of the equations: a step costs several times as much. Where such a fit ends is a minimum, whatever its start and
  // its way; one of active points stops near it, where they no longer lead down.
  bool all_points = false;
};

// The normal equations of a code where a fit has ended.
struct CodeEquations {
  int count = 0;         // K
  AlignedFloats matrix;  // K x K, symmetric, both triangles: J^T J and the prior

  // The matrix becomes U, upper triangular, U^T U what it was; the numbers below the diagonal are any. False where it has none.
  bool factor();
};

// Of a cell: a pass leaves it out where the logits at all of its corners are above `open`, or below `shut`.
struct CellLimits {
  float open, shut;
};

// One of these a thread: it keeps its workspace.
class CodeFit {
 public:
  // Steps in place.
  // function   in the order of the representation, a code
  // count      numbers of the code that are fitted, a multiple of 8: those behind are set to 0
  // z          K floats; becomes the better of where the steps end and what it was
  // returns    rmse (of rounded logits), steps and stop of the fit, without its theta
  FitResult iterate(const Representation& representation, const WeightingFunction& function, const CodeFitOptions& options,
                    int count, float* z);

  // Of all K numbers, at full weights and without kappa.
  void equationsAt(const Representation& representation, const WeightingFunction& function, const CodeFitOptions& options,
                   const float* z, CodeEquations* equations);

 private:
  // What one pass over all points leaves: sums of squared residuals, of dark points without their weight, and a row of the equations for
  // every active point, at some weight of dark points and some kappa.
  struct Pass {
    double lit_square = 0.0, dark_square = 0.0;
    float dark_root = 1.0f, kappa = 0.0f;
    std::vector<int> place;
    AlignedFloats slope, residual;
    int active_count = 0;
  };

  void prepare(const Representation& representation);
  // limits   of the function's cells; null: none is left out
  void runPass(const WeightingFunction& function, int count, const float* z, float dark_root, float kappa,
               const CellLimits* limits, Pass* pass);
  double priorCost(const CodeFitOptions& options, int count, const float* z) const;
  enum class RowsOf { points, pairs };
  // J^T J and J^T r of a pass, and kappa's share of it.
  void addEquations(const Pass& pass, int count, float kappa, RowsOf rows);
  bool solveStep(const CodeFitOptions& options, int count, double damping, const float* z, float* trial);

  SharedDictionary dictionary_;  // that all below is made for
  const PointOrder* order_ = nullptr;
  bool all_points_ = false;         // CodeFitOptions::all_points of the present call
  std::vector<CellLimits> limits_;  // of the present function
  std::vector<uint16_t> cell_of_;   // by place
  AlignedFloats logits_, matrix_, factor_, gradient_, rows_;
  std::vector<float> trial_, start_;
  Pass best_, other_;
};

}  // namespace nlg
