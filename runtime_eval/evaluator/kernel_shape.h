// The shape of a representation that kernels are compiled for, and their order of the support points.
//
// Another network is one line of kNetworks (nlg/representation.h): all kernels of the bake are templates over its shape. Shaders name theirs
// (runtime_eval/shader_grid).
#pragma once

#include <array>
#include <utility>

#include "runtime_eval/evaluator/dictionary.h"

namespace nlg {

inline constexpr int kFieldResolutions[] = {3, 5, 7, 9};
inline constexpr int kMaxThetaCount = 2 * 9 * 9 * 9;

// The largest D of a network: what kernels need of memory.
constexpr int maxNetworkThetaCount() {
  int count = 0;
  for (const NetworkKind& network : kNetworks) {
    if (network.shape.thetaCount() > count) count = network.shape.thetaCount();
  }
  return count;
}
inline constexpr int kMaxNetworkThetaCount = maxNetworkThetaCount();

// The layout of `mlp` and `tent_mlp`, the talk's network.
inline constexpr int kHiddenCount = 8;
struct ThetaLayout {
  static constexpr NetworkShape shape{};
  static constexpr int w1 = shape.w1(), b1 = shape.b1(), w2 = shape.w2(), b2 = shape.b2(), w3 = shape.w3(), b3 = shape.b3(),
                       count = shape.thetaCount();
};

// Calls operation.template operator()<shape>() with the shape of a network as a constant: how kernels are chosen.
template <class Operation>
auto withNetworkShape(const Representation& network, const Operation& operation) {
  using Result = decltype(operation.template operator()<kNetworks[0].shape>());
  using Call = Result (*)(const Operation&);
  static constexpr auto calls = []<size_t... kIndices>(std::index_sequence<kIndices...>) {
    return std::array<Call, sizeof...(kIndices)>{
        [](const Operation& o) -> Result { return o.template operator()<kNetworks[kIndices].shape>(); }...};
  }
  (std::make_index_sequence<kNetworkCount>());
  return calls[static_cast<size_t>(network.kind)](operation);
}

// The order in which a representation's kernels read the support points: strata for networks, cells for product fields and codes.
const PointOrder& pointOrder(const Representation& representation);

}  // namespace nlg
