// Ground truth of a view, and its file, so that later comparisons need not trace it again.
//
// A file is a safetensors file (weights_file/tensor_file.h) whose metadata holds a SHA-256 of everything that decides its numbers:
// the scene with its light, every receiver, rays, bounces, seed, which light counts, and kTruthVersion. Where that is another the
// view is traced anew, and the file replaced.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "light/light_transport.h"
#include "render/lit_picture.h"
#include "render/sight.h"
#include "validate/views/scene_views.h"

namespace nlg {

// What a view sees, before any light is known, and which of the figures each receiver counts in.
//
// Receivers may be of several classes; all of `all`.
enum class ViewClass : uint8_t {
  all,
  edge,    // a surface rises beside the receiver, within 10 cm along the plane that it lies in
  shadow,  // where no sun shines, in scenes that have suns
  figure,  // on the figure, not on the scene's own surfaces, which alone have edges
};
inline constexpr std::array<const char*, 4> kViewClassNames = {"all", "edge", "shadow", "figure"};
inline constexpr size_t kViewClassCount = kViewClassNames.size();

inline constexpr double kEdgeM = 0.1;

struct ViewSurfaces {
  Sights sights;
  std::vector<uint8_t> classes;  // by sample: bit c for class c; 0 of samples without a receiver

  bool isOf(size_t sample, ViewClass of_class) const { return classes[sample] >> static_cast<int>(of_class) & 1; }
};

// One sample a pixel: what is drawn is what is measured. The same for any number of threads.
ViewSurfaces surfacesOf(const LightTransport& transport, const SceneView& view, int width, int height, int thread_count);

inline constexpr int kTruthVersion = 1;  // to be raised when the path tracer gives other numbers for the same scene

inline constexpr int kMostTruthRounds = 8;

struct ViewTruthOptions {
  GatherOptions gather;  // of a round
  // After the first round as many follow as bring medianNoise down to this, kMostTruthRounds in all at most. No round is judged by
  // what it is to be: what is stopped where it looks sure is too dark where light comes seldom.
  double noise = 0.1;
  uint64_t seed = 1;
  int thread_count = 1;
  std::string scene_sha256;  // sceneLightSha256 of the transport's scene
};

struct TracedView {
  std::vector<LightAnswer> at;  // by sample; samples without a receiver are black
  int rounds = 0;
  bool was_read = false;  // from its file
};

// The median over receivers that are not black of the standard deviation over the light itself; 0 where all are.
double medianNoise(const std::vector<LightAnswer>& truth);

// path     of the view's file, read if it is of this view, else written; empty: none
// throws   OutputError; a file that is there and cannot be used is said on stderr, and replaced
TracedView viewTruth(const LightTransport& transport, const Sights& sights, const ViewTruthOptions& options,
                     const std::string& path);

}  // namespace nlg
