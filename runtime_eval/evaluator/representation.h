// The representations: what stands for a weighting function at run time, and how its parameters theta lie in memory.
//
//     mlp        phi(x) ≈           net(x)
//     tent_mlp   phi(x) ≈ tent(x) * net(x)
//
// net is the talk's tiny network 3 → 8 → 8 → 1 with LeakyReLU after both hidden layers. theta, 113 floats:
//     W1 8x3 | b1 8 | W2 8x8 | b2 8 | w3 8 | b3 1        (row-major, one row an output)
#pragma once

#include <string_view>

namespace nlg {

inline constexpr int kHiddenCount = 8;
inline constexpr int kThetaCount = 113;  // D

// Where each layer's parameters begin in theta.
struct ThetaLayout {
  static constexpr int w1 = 0, b1 = 24, w2 = 32, b2 = 96, w3 = 104, b3 = 112;
};

struct Representation {
  bool tent_factor = false;  // tent_mlp
  float slope = 0.01f;       // LeakyReLU: x for x > 0, slope * x below; 0 < slope < 1; travels in the weights file
};

// "mlp" or "tent_mlp".
const char* representationName(const Representation& representation);

// The representation of a name, with the default slope; false when there is none of that name.
bool findRepresentation(std::string_view name, Representation* representation);

// The names of all representations, in the order of the report.
inline constexpr const char* kRepresentationNames[] = {"mlp", "tent_mlp"};

}  // namespace nlg
