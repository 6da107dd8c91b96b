// The representations: forms of a weighting function at run time, and the layout of their parameters theta.
//
//     mlp          phi(x) ≈           net(x)               3 → 8 → 8 → 1      113 numbers
//     tent_mlp     phi(x) ≈ tent(x) * net(x)               3 → 8 → 8 → 1      113
//     tent_mlp44   phi(x) ≈ tent(x) * sigmoid(net(x))      3 → 4 → 4 → 1       41
//     tent_mlp4    phi(x) ≈ tent(x) * sigmoid(net(x))      3 → 4 → 1           21
//     pf r         phi(x) ≈ clamp(A(x), 0, 1) * sigmoid(B(x))      product field, r = 3, 5, 7, 9
//     code K       phi(x) ≈ tent(x) * sigmoid(L(x))                a code, K = 16, 32, 48, 64, 128
//
// net is a tiny network with one or two hidden layers, each followed by LeakyReLU. Layout of theta for widths m, n:
//     W1 m x 3 | b1 m | W2 n x m | b2 n | w3 n | b3 1        (row-major, one row per output)
//     W1 m x 3 | b1 m | w3 m | b3 1                          (one hidden layer: n = 0)
// A and B are trilinear in r³ nodes that cover [-1, 1]³. theta has 2 r³ floats: the pair (A, B) of every node, x fastest, as in a
// texture of two channels. L is a sum of K fields of a dictionary that all functions share, each times a factor; theta are the
// factors.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "nlg/support.h"

namespace nlg {

class Dictionary;  // what codes share: runtime_eval/evaluator/dictionary.h
using SharedDictionary = std::shared_ptr<const Dictionary>;

enum class OutputFunction : uint8_t { linear, sigmoid };

// The shape of a network, for which kernels are compiled. Widths are even; `second` is 0 for one hidden layer.
struct NetworkShape {
  int first = 8, second = 8;
  OutputFunction output = OutputFunction::linear;

  constexpr bool operator==(const NetworkShape&) const = default;
  // width of the last hidden layer
  constexpr int last() const { return second > 0 ? second : first; }
  // Where each layer's parameters begin in theta.
  constexpr int w1() const { return 0; }
  constexpr int b1() const { return 3 * first; }
  constexpr int w2() const { return b1() + first; }
  constexpr int b2() const { return w2() + first * second; }
  constexpr int w3() const { return b2() + second; }
  constexpr int b3() const { return w3() + last(); }
  constexpr int thetaCount() const { return b3() + 1; }
};

struct NetworkKind {
  const char* name;
  NetworkShape shape;
  bool tent_factor;
};

// All networks, in the order of RepresentationKind.
inline constexpr NetworkKind kNetworks[] = {
    {"mlp", {8, 8, OutputFunction::linear}, false},
    {"tent_mlp", {8, 8, OutputFunction::linear}, true},
    {"tent_mlp44", {4, 4, OutputFunction::sigmoid}, true},
    {"tent_mlp4", {4, 0, OutputFunction::sigmoid}, true},
};
inline constexpr int kNetworkCount = static_cast<int>(std::size(kNetworks));

struct FieldKind {
  const char* name;
  int resolution;
};

// All product fields.
inline constexpr FieldKind kFields[] = {{"pf3", 3}, {"pf5", 5}, {"pf7", 7}, {"pf9", 9}};

struct CodeKind {
  const char* name;
  int count;
};

// All codes.
inline constexpr CodeKind kCodes[] = {{"code16", 16}, {"code32", 32}, {"code48", 48}, {"code64", 64}, {"code128", 128}};

// Networks have their index in kNetworks.
enum class RepresentationKind : uint8_t { mlp, tent_mlp, tent_mlp44, tent_mlp4, code = 254, product_field = 255 };

struct Representation {
  RepresentationKind kind = RepresentationKind::mlp;
  float slope = 0.01f;  // networks: LeakyReLU is x for x > 0, else slope * x; 0 < slope < 1; stored in the weights file
  int resolution = 0;   // product fields, and bricks of codes: nodes along an axis
  int code_count = 0;   // codes: K
  // Codes: the shared dictionary. Null if only the name is known; then nothing can be evaluated.
  SharedDictionary dictionary;

  static Representation mlp(float slope = 0.01f) { return {RepresentationKind::mlp, slope, 0, 0, nullptr}; }
  static Representation tentMlp(float slope = 0.01f) { return {RepresentationKind::tent_mlp, slope, 0, 0, nullptr}; }
  static Representation productField(int resolution) {
    return {RepresentationKind::product_field, 0.01f, resolution, 0, nullptr};
  }
  static Representation code(SharedDictionary dictionary);

  bool isField() const { return kind == RepresentationKind::product_field; }
  bool isCode() const { return kind == RepresentationKind::code; }
  bool isNetwork() const { return !isField() && !isCode(); }
  bool tentFactor() const { return isCode() || (isNetwork() && network().tent_factor); }
  // Returns D, the number of floats in theta.
  int thetaCount() const {
    return isField() ? 2 * resolution * resolution * resolution : isCode() ? code_count : network().shape.thetaCount();
  }
  // Only for networks.
  const NetworkKind& network() const { return kNetworks[static_cast<int>(kind)]; }
  const NetworkShape& shape() const { return network().shape; }
  bool hasLinearOutput() const { return isNetwork() && shape().output == OutputFunction::linear; }
};

// The D parameters of one function in one representation.
using Theta = std::vector<float>;

// The number format in which a light grid stores theta.
enum class ThetaPrecision : uint8_t { float32, float16, int8 };

// The names of all representations, in the order of the report.
inline constexpr auto kRepresentationNames = [] {
  std::array<const char*, std::size(kNetworks) + std::size(kFields) + std::size(kCodes)> names{};
  size_t count = 0;
  for (const NetworkKind& network : kNetworks) names[count++] = network.name;
  for (const FieldKind& field : kFields) names[count++] = field.name;
  for (const CodeKind& code : kCodes) names[count++] = code.name;
  return names;
}();

// Returns one of kRepresentationNames, as "tent_mlp4".
const char* representationName(const Representation& representation);

// Returns all names in one text for messages, with commas between them and "or" before the last.
std::string representationNames();

// Finds the representation of a name, with the default slope and without a dictionary.
// name      as "tent_mlp4"
// returns   false if there is none of that name
bool findRepresentation(std::string_view name, Representation* representation);

// Evaluates one theta at `count` points, on vectors.
// points   count points in [-1, 1]³, one unit being one probe spacing
// theta    D floats
// phi      count floats, overwritten; not clamped to [0, 1]
void evaluate(const Representation& representation, const LocalPoint* points, size_t count, const float* theta, float* phi);

}  // namespace nlg
