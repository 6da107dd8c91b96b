// Ground truth of a view, and its file: tracing it takes minutes, and bakes of one scene are compared again and again.
//
// A file is a safetensors file (weights_file/tensor_file.h) whose metadata holds a SHA-256 of everything that decides its numbers:
// the scene with its light, every receiver, rays, bounces, seed, which light counts, and kTruthVersion. Where that is another the
// view is traced anew, and the file replaced.
#pragma once

#include <string>
#include <vector>

#include "light/light_transport.h"
#include "render/lit_picture.h"
#include "render/sight.h"

namespace nlg {

inline constexpr int kTruthVersion = 1;  // to be raised when the path tracer gives other numbers for the same scene

inline constexpr int kMostTruthRounds = 8;

struct ViewTruthOptions {
  GatherOptions gather;  // of a round
  // After the first round as many follow as bring medianNoise down to this, kMostTruthRounds in all at most. No round is judged by
  // what it is to be: what is stopped where it looks sure is too dark where light comes seldom.
  double noise = 0.05;
  uint64_t seed = 1;
  int thread_count = 1;
  std::string scene_sha256;  // sceneLightSha256 of the transport's scene
};

struct TracedView {
  std::vector<ReceivedLight> at;  // by sample; samples without a receiver are black
  int rounds = 0;
  bool was_read = false;  // from its file
};

// The median over receivers that are not black of the standard deviation over the light itself; 0 where all are.
double medianNoise(const std::vector<ReceivedLight>& truth);

// path     of the view's file, read if it is of this view, else written; empty: none
// throws   OutputError; a file that is there and cannot be used is said on stderr, and replaced
TracedView viewTruth(const LightTransport& transport, const Sights& sights, const ViewTruthOptions& options,
                     const std::string& path);

}  // namespace nlg
