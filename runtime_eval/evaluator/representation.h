// The representations: what stands for a weighting function at run time, and how its parameters theta lie in memory.
//
//     mlp        phi(x) ≈           net(x)
//     tent_mlp   phi(x) ≈ tent(x) * net(x)
//     pf r       phi(x) ≈ clamp(A(x), 0, 1) * sigmoid(B(x))      product field, r = 3, 5, 7, 9
//
// net is the talk's tiny network 3 → 8 → 8 → 1 with LeakyReLU after both hidden layers. theta, 113 floats:
//     W1 8x3 | b1 8 | W2 8x8 | b2 8 | w3 8 | b3 1        (row-major, one row an output)
// A and B are trilinear in r³ nodes that cover [-1, 1]³. theta, 2 r³ floats: the pair (A, B) of every node, x fastest, as a
// texture of two channels holds them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime_eval/support/point_order.h"

namespace nlg {

inline constexpr int kHiddenCount = 8;

// Where each layer's parameters begin in the theta of a network.
struct ThetaLayout {
  static constexpr int w1 = 0, b1 = 24, w2 = 32, b2 = 96, w3 = 104, b3 = 112, count = 113;
};

enum class RepresentationKind { mlp, tent_mlp, product_field };

struct Representation {
  RepresentationKind kind = RepresentationKind::mlp;
  float slope = 0.01f;  // networks: LeakyReLU, x for x > 0, slope * x below; 0 < slope < 1; travels in the weights file
  int resolution = 0;   // product fields: nodes along an axis

  static constexpr Representation mlp(float slope = 0.01f) { return {RepresentationKind::mlp, slope, 0}; }
  static constexpr Representation tentMlp(float slope = 0.01f) { return {RepresentationKind::tent_mlp, slope, 0}; }
  static constexpr Representation productField(int resolution) { return {RepresentationKind::product_field, 0.01f, resolution}; }

  bool isField() const { return kind == RepresentationKind::product_field; }
  bool tentFactor() const { return kind == RepresentationKind::tent_mlp; }
  // D: how many numbers theta has.
  int thetaCount() const { return isField() ? 2 * resolution * resolution * resolution : ThetaLayout::count; }
};

inline constexpr int kFieldResolutions[] = {3, 5, 7, 9};
inline constexpr int kMaxThetaCount = 2 * 9 * 9 * 9;

// D numbers of one representation.
using Theta = std::vector<float>;

// The names of all representations, in the order of the report.
inline constexpr const char* kRepresentationNames[] = {"mlp", "tent_mlp", "pf3", "pf5", "pf7", "pf9"};

// The order in which a representation's kernels read the support points: strata for networks, cells for product fields.
const PointOrder& pointOrder(const Representation& representation);

// One of kRepresentationNames.
const char* representationName(const Representation& representation);

// "mlp, tent_mlp, … or pf9", for messages.
std::string representationNames();

// The representation of a name, with the default slope; false when there is none of that name.
bool findRepresentation(std::string_view name, Representation* representation);

}  // namespace nlg
