#include "datagen/view/level_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nlg {
namespace {

constexpr int kOversampling = 2;  // samples a pixel, along each side
constexpr float kNothing = -std::numeric_limits<float>::infinity();

// What was found at every sample.
struct Samples {
  int width, height;
  std::vector<float> top_m;        // of the highest face below the cut that looks up or has two sides
  std::vector<float> back_m;       // of the highest back of a one-sided face below the cut
  std::vector<float> upward;       // y of the seen face's normal
  std::vector<int16_t> enclosing;  // backs less fronts below the cut: the closed solids that hold the cut's point

  Samples(int w, int h)
      : width(w), height(h), top_m(size_t(w) * h, kNothing), back_m(top_m), upward(top_m.size()), enclosing(top_m.size()) {}
  size_t at(int x, int y) const { return static_cast<size_t>(y) * width + x; }
  bool isSolid(size_t i) const { return back_m[i] > top_m[i] || enclosing[i] > 0; }
};

// Twice the area of (a, b, c), with exactly the opposite sign for (b, a, c): two triangles agree on their common edge.
double edgeSide(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  if (b.x < a.x || (b.x == a.x && b.y < a.y)) return -edgeSide(b, a, c);
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Whether a sample exactly on the edge belongs to the triangle that lies on its positive side.
bool ownsEdge(const glm::dvec2& a, const glm::dvec2& b) { return b.y > a.y || (b.y == a.y && b.x > a.x); }

void rasterise(const ViewTriangle& triangle, const LevelMap& map, double cut_m, Samples& samples) {
  const auto& [a, b, c] = triangle.corners;
  // vertical faces have no area from above; what lies above the cut is taken off
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  if (normal.y == 0.0 || std::min({a.y, b.y, c.y}) > cut_m) return;
  const bool is_back = normal.y < 0.0 && !triangle.double_sided;
  // cosine to the vertical, for shading
  const auto upward = static_cast<float>(std::fabs(normal.y) / glm::length(normal));
  glm::dvec2 p[3];
  for (int i = 0; i < 3; ++i) p[i] = map.pixelOf(triangle.corners[i]) * double(kOversampling);
  // one winding for all, so that signed areas are positive inside
  double corner_m[3] = {a.y, b.y, c.y};
  if (edgeSide(p[0], p[1], p[2]) < 0.0) std::swap(p[1], p[2]), std::swap(corner_m[1], corner_m[2]);
  const double area = edgeSide(p[0], p[1], p[2]);
  const glm::dvec2 low = glm::min(p[0], glm::min(p[1], p[2])), high = glm::max(p[0], glm::max(p[1], p[2]));
  const auto clamped = [](double at, int end) { return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(end))); };
  const int x0 = clamped(std::floor(low.x), samples.width), x1 = clamped(std::ceil(high.x), samples.width);
  const int y1 = clamped(std::ceil(high.y), samples.height);
  for (int y = clamped(std::floor(low.y), samples.height); y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const glm::dvec2 centre(x + 0.5, y + 0.5);
      double height_m = 0.0;
      bool is_inside = area > 0.0;
      // barycentric: sides over the area are weights of the corners. A sample on a shared edge belongs to one triangle
      for (int i = 0; i < 3 && is_inside; ++i) {
        const glm::dvec2 &from = p[(i + 1) % 3], &to = p[(i + 2) % 3];
        const double side = edgeSide(from, to, centre);
        is_inside = side > 0.0 || (side == 0.0 && ownsEdge(from, to));
        height_m += side / area * corner_m[i];
      }
      if (!is_inside) continue;
      if (height_m > cut_m) continue;
      const size_t at = samples.at(x, y);
      float& top = is_back ? samples.back_m[at] : samples.top_m[at];
      // below the cut a back begins a solid that reaches up to it, and a front ends one
      if (!triangle.double_sided) samples.enclosing[at] = static_cast<int16_t>(samples.enclosing[at] + (is_back ? 1 : -1));
      if (static_cast<float>(height_m) <= top) continue;
      top = static_cast<float>(height_m);
      if (!is_back) samples.upward[at] = upward;
    }
  }
}

// Whether the seen surface jumps between this sample and its right or lower neighbour.
bool isStep(const Samples& samples, int x, int y, double step_m) {
  const float here = samples.top_m[samples.at(x, y)];
  const auto differs = [&](float there) { return (here == kNothing) != (there == kNothing) || std::fabs(here - there) > step_m; };
  return (x + 1 < samples.width && differs(samples.top_m[samples.at(x + 1, y)])) ||
         (y + 1 < samples.height && differs(samples.top_m[samples.at(x, y + 1)]));
}

}  // namespace

LevelMap makeLevelMap(const glm::dvec3& low_m, const glm::dvec3& high_m, int side_px) {
  constexpr double kMargin = 0.03;  // of the longer side
  const glm::dvec2 low(low_m.x, low_m.z), size(high_m.x - low_m.x, high_m.z - low_m.z);
  const double side_m = std::max({size.x, size.y, 1e-3}), margin_m = kMargin * side_m;
  LevelMap map;
  map.low_m = low - margin_m;
  map.px_per_m = side_px / (side_m + 2 * margin_m);
  map.width = std::max(1, static_cast<int>(std::lround((size.x + 2 * margin_m) * map.px_per_m)));
  map.height = std::max(1, static_cast<int>(std::lround((size.y + 2 * margin_m) * map.px_per_m)));
  return map;
}

Colour heightColour(double share) { return mix({112, 122, 146}, {240, 233, 220}, std::clamp(share, 0.0, 1.0)); }

Image drawLevel(const std::vector<ViewTriangle>& triangles, const LevelMap& map, double floor_m, double cut_m) {
  constexpr double kStepM = 0.3;  // a stair is not a step, a table is
  Samples samples(map.width * kOversampling, map.height * kOversampling);
  for (const ViewTriangle& triangle : triangles) rasterise(triangle, map, cut_m, samples);
  Image image(samples.width, samples.height, kMapGround);
  for (int y = 0; y < samples.height; ++y) {
    for (int x = 0; x < samples.width; ++x) {
      const size_t at = samples.at(x, y);
      const float top = samples.top_m[at];
      if (top != kNothing) {
        const Colour flat = heightColour((top - floor_m) / std::max(cut_m - floor_m, 1e-6));
        image.set(x, y, mix(kBlack, flat, 0.55 + 0.45 * samples.upward[at]));
        if (isStep(samples, x, y, kStepM)) image.blend(x, y, kBlack, 0.45);
      }
      if (samples.isSolid(at)) image.blend(x, y, hatchColour(x / kOversampling, y / kOversampling), 0.6);
    }
  }
  return halved(image);
}

double mostTellingHeight(const std::vector<ViewTriangle>& triangles, const LevelMap& map, double low_m, double high_m) {
  constexpr int kCandidates = 25, kCoarseSide = 64;
  // tried on a small map: 25 heights in the middle half of the scene
  LevelMap coarse = map;
  const double shrink = static_cast<double>(kCoarseSide) / std::max(map.width, map.height);
  coarse.px_per_m *= shrink;
  coarse.width = std::max(1, static_cast<int>(map.width * shrink));
  coarse.height = std::max(1, static_cast<int>(map.height * shrink));
  std::vector<double> heights_m, scores;
  for (int i = 0; i < kCandidates; ++i) {
    const double height_m = low_m + (high_m - low_m) * (0.25 + 0.5 * (i + 0.5) / kCandidates);
    // long cuts show walls, open floor shows rooms: the product prefers heights with both
    double length_m = 0.0;
    for (const CutSegment& segment : cutTriangles(triangles, 1, height_m)) length_m += glm::length(segment.b - segment.a);
    Samples samples(coarse.width * kOversampling, coarse.height * kOversampling);
    for (const ViewTriangle& triangle : triangles) rasterise(triangle, coarse, height_m, samples);
    int open_count = 0;
    for (size_t at = 0; at < samples.top_m.size(); ++at) open_count += samples.top_m[at] != kNothing && !samples.isSolid(at);
    heights_m.push_back(height_m);
    scores.push_back(length_m * open_count);
  }
  // of those that are nearly as good as the best, the one nearest to the middle
  constexpr double kNearly = 0.9;
  const double middle_m = 0.5 * (low_m + high_m), wanted = kNearly * *std::max_element(scores.begin(), scores.end());
  size_t best = scores.size();
  for (size_t i = 0; i < scores.size(); ++i) {
    if (scores[i] < wanted) continue;
    if (best == scores.size() || std::fabs(heights_m[i] - middle_m) < std::fabs(heights_m[best] - middle_m)) best = i;
  }
  return heights_m[best];
}

}  // namespace nlg
