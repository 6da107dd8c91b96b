// What a view sees, before any light is known, and which of the figures each receiver counts in.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/sight.h"
#include "validate/views/scene_views.h"

namespace nlg {

// Receivers may be of several classes; all of `all`.
enum class ViewClass : uint8_t {
  all,
  edge,    // a surface rises beside the receiver, within 10 cm along the plane that it lies in
  near,    // another surface stands within 5 cm
  sun,     // the middle of a sun is seen from there, and shines on it
  shadow,  // the rest, in scenes that have suns
  figure,  // on the figure, not on the scene's own surfaces: the figure is of none of edge and near
};
inline constexpr std::array<const char*, 6> kViewClassNames = {"all", "edge", "near", "sun", "shadow", "figure"};
inline constexpr size_t kViewClassCount = kViewClassNames.size();

inline constexpr double kEdgeM = 0.1, kNearM = 0.05;

struct ViewSurfaces {
  Sights sights;
  std::vector<uint8_t> classes;  // by sample: bit c for class c; 0 of samples without a receiver

  bool isOf(size_t sample, ViewClass of_class) const { return classes[sample] >> static_cast<int>(of_class) & 1; }
};

// One sample a pixel: what is drawn is what is measured. The same for any number of threads.
ViewSurfaces surfacesOf(const LightTransport& transport, const SceneView& view, int width, int height, int thread_count);

}  // namespace nlg
