#include "datagen/view/function_slice.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

constexpr int kTile = 16;  // pixels: neighbours share their candidates

struct Candidate {
  glm::dvec3 local;
  float phi = 0;
  PixelKind kind = PixelKind::unknown;
};

std::vector<Candidate> allPoints(const StoredFunction& function) {
  const std::vector<LocalPoint>& points = supportPattern().points;
  std::vector<Candidate> result(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    result[i].local = glm::dvec3(points[i][0], points[i][1], points[i][2]);
    result[i].phi = static_cast<float>(function.phi[i]) / 255.0f;
    result[i].kind = !function.isValid(i) ? PixelKind::solid : function.isSeen(i) ? PixelKind::seen : PixelKind::diffused;
  }
  return result;
}

struct Pixel {
  PixelKind kind = PixelKind::unknown;
  float phi = 0, seen_share = 0;
};

struct Weighted {
  const Candidate* point = nullptr;
  glm::dvec3 offset;  // from the pixel, shares of the reach
  double weight = 0;
};

// The value at offset 0 of the plane of least squares through the points of one kind.
float fittedValue(const std::vector<Weighted>& near, PixelKind kind) {
  // slopes are damped: a plane through few points, or through points in one line, stays a sensible one
  constexpr double kDamping = 0.02;
  glm::dmat4 normal(0.0);
  glm::dvec4 right_side(0.0);
  float low = 1.0f;
  for (const Weighted& entry : near) {
    if (entry.point->kind != kind) continue;
    const glm::dvec4 row(1.0, entry.offset);
    normal += entry.weight * glm::outerProduct(row, row);
    right_side += entry.weight * double(entry.point->phi) * row;
    low = std::min(low, entry.point->phi);
  }
  for (int i = 1; i < 4; ++i) normal[i][i] += kDamping * normal[0][0];
  const glm::dvec4 plane = glm::inverse(normal) * right_side;
  return std::clamp(static_cast<float>(plane[0]), low, 1.0f);
}

Pixel blended(const std::vector<Weighted>& near) {
  double weight[4] = {};
  for (const Weighted& entry : near) weight[static_cast<int>(entry.point->kind)] += entry.weight;
  const double solid = weight[static_cast<int>(PixelKind::solid)], seen = weight[static_cast<int>(PixelKind::seen)];
  const double valid = seen + weight[static_cast<int>(PixelKind::diffused)];
  Pixel pixel;
  if (solid + valid == 0.0) return pixel;
  if (valid > 0.0) pixel.seen_share = static_cast<float>(seen / valid);
  pixel.kind = solid > valid ? PixelKind::solid : pixel.seen_share >= 0.5f ? PixelKind::seen : PixelKind::diffused;
  if (pixel.kind != PixelKind::solid) pixel.phi = fittedValue(near, pixel.kind);
  return pixel;
}

Pixel visiblePixel(const glm::dvec3& local, const std::vector<const Candidate*>& points,
                   const std::vector<const ViewTriangle*>& triangles, std::vector<Weighted>& near) {
  near.clear();
  for (const Candidate* point : points) {
    const glm::dvec3 offset = (point->local - local) / kSliceReach;
    const double rest = 1.0 - glm::dot(offset, offset);
    if (rest <= 0.0) continue;
    const bool is_hidden = std::any_of(triangles.begin(), triangles.end(), [&](const ViewTriangle* triangle) {
      return meetsTriangle(local, point->local, *triangle);
    });
    if (!is_hidden) near.push_back({point, offset, rest * rest});
  }
  return blended(near);
}

Pixel nearestPixel(const glm::dvec3& local, const std::vector<const Candidate*>& points) {
  const auto squared = [&](const Candidate* point) { return glm::dot(point->local - local, point->local - local); };
  const auto nearest = std::min_element(points.begin(), points.end(),
                                        [&](const Candidate* a, const Candidate* b) { return squared(a) < squared(b); });
  Pixel pixel;
  if (nearest == points.end()) return pixel;
  pixel.kind = (*nearest)->kind;
  pixel.seen_share = pixel.kind == PixelKind::seen ? 1.0f : 0.0f;
  if (pixel.kind != PixelKind::solid) pixel.phi = (*nearest)->phi;
  return pixel;
}

glm::dvec3 pixelCentre(const FunctionSlice& slice, int x, int y) {
  return slice.plane.toLocal({2.0 * (x + 0.5) / slice.size - 1.0, 2.0 * (y + 0.5) / slice.size - 1.0});
}

void fillTile(const std::vector<Candidate>& all, const std::vector<ViewTriangle>* triangles, int x0, int y0,
              FunctionSlice& slice) {
  const int x1 = std::min(x0 + kTile, slice.size), y1 = std::min(y0 + kTile, slice.size);
  const glm::dvec3 corner_a = pixelCentre(slice, x0, y0), corner_b = pixelCentre(slice, x1 - 1, y1 - 1);
  // without a wall in the way the nearest point may stand a little farther than the reach of the smooth picture
  const double reach = triangles != nullptr ? kSliceReach : 1.5 * kSliceReach;
  const glm::dvec3 low = glm::min(corner_a, corner_b) - reach, high = glm::max(corner_a, corner_b) + reach;
  std::vector<const Candidate*> points;
  for (const Candidate& point : all) {
    if (glm::all(glm::greaterThan(point.local, low)) && glm::all(glm::lessThan(point.local, high))) points.push_back(&point);
  }
  std::vector<const ViewTriangle*> near_triangles;
  if (triangles != nullptr) {
    for (const ViewTriangle& triangle : *triangles) {
      if (mayMeetBox(triangle, low, high)) near_triangles.push_back(&triangle);
    }
  }
  std::vector<Weighted> near;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const glm::dvec3 local = pixelCentre(slice, x, y);
      const Pixel pixel = triangles != nullptr ? visiblePixel(local, points, near_triangles, near) : nearestPixel(local, points);
      const size_t at = static_cast<size_t>(y) * slice.size + x;
      slice.kind[at] = pixel.kind;
      slice.phi[at] = pixel.phi;
      slice.seen_share[at] = pixel.seen_share;
    }
  }
}

}  // namespace

std::vector<ViewTriangle> trianglesNear(const Scene& scene, const glm::dvec3& centre_m, double unit_m, double reach) {
  std::vector<ViewTriangle> result;
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    ViewTriangle triangle;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position = scene.origin_m + glm::dvec3(scene.positions[scene.triangles[i][corner]]);
      triangle.corners[corner] = (position - centre_m) / unit_m;
    }
    triangle.double_sided = scene.materials[scene.triangle_material[i]].double_sided;
    const auto& [a, b, c] = triangle.corners;
    const glm::dvec3 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
    if (glm::all(glm::lessThanEqual(low, glm::dvec3(reach))) && glm::all(glm::greaterThanEqual(high, glm::dvec3(-reach)))) {
      result.push_back(triangle);
    }
  }
  return result;
}

std::vector<CutSegment> cutTriangles(const std::vector<ViewTriangle>& triangles, int axis, double offset) {
  std::vector<CutSegment> segments;
  for (const ViewTriangle& triangle : triangles) {
    glm::dvec3 ends[2];
    int end_count = 0;
    for (int i = 0; i < 3; ++i) {
      // from the lower to the upper corner, whichever comes first: two triangles give their common edge the same point
      glm::dvec3 low = triangle.corners[i], high = triangle.corners[(i + 1) % 3];
      if (low[axis] >= offset) std::swap(low, high);
      if (low[axis] >= offset || high[axis] < offset) continue;
      glm::dvec3 end = low + (high - low) * ((offset - low[axis]) / (high[axis] - low[axis]));
      end[axis] = offset;
      ends[end_count++] = end;
    }
    if (end_count == 2 && ends[0] != ends[1]) segments.push_back({ends[0], ends[1], triangle.double_sided});
  }
  return segments;
}

bool meetsTriangle(const glm::dvec3& a, const glm::dvec3& b, const ViewTriangle& triangle) {
  const glm::dvec3 edge1 = triangle.corners[1] - triangle.corners[0], edge2 = triangle.corners[2] - triangle.corners[0];
  const glm::dvec3 step = b - a, p = glm::cross(step, edge2), s = a - triangle.corners[0];
  const double determinant = glm::dot(edge1, p);
  if (determinant == 0.0) return false;
  const double u = glm::dot(s, p) / determinant;
  if (!(u >= 0.0 && u <= 1.0)) return false;
  const glm::dvec3 q = glm::cross(s, edge1);
  const double v = glm::dot(step, q) / determinant, t = glm::dot(edge2, q) / determinant;
  return v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= 1.0;
}

bool mayMeetBox(const ViewTriangle& triangle, const glm::dvec3& low, const glm::dvec3& high) {
  const auto& [a, b, c] = triangle.corners;
  const glm::dvec3 triangle_low = glm::min(a, glm::min(b, c)), triangle_high = glm::max(a, glm::max(b, c));
  if (glm::any(glm::greaterThan(triangle_low, high)) || glm::any(glm::lessThan(triangle_high, low))) return false;
  const glm::dvec3 normal = glm::cross(b - a, c - a), half = 0.5 * (high - low);
  return std::fabs(glm::dot(normal, 0.5 * (low + high) - a)) <= glm::dot(glm::abs(normal), half);
}

glm::dvec3 PlaneView::toLocal(const glm::dvec2& picture) const {
  glm::dvec3 local(0.0);
  local[right] = picture.x;
  local[up] = -up_sign * picture.y;
  return local;
}

PlaneView planeView(int normal) {
  if (normal == 0) return {0, 2, 1, 1.0};
  if (normal == 1) return {1, 0, 2, -1.0};
  return {2, 0, 1, 1.0};
}

FunctionSlice makeFunctionSlice(const StoredFunction& function, int normal, int size,
                                const std::vector<ViewTriangle>* triangles) {
  FunctionSlice slice;
  slice.plane = planeView(normal);
  slice.size = size;
  const size_t count = static_cast<size_t>(size) * size;
  slice.kind.resize(count);
  slice.phi.resize(count);
  slice.seen_share.resize(count);
  const std::vector<Candidate> all = allPoints(function);
  for (int y = 0; y < size; y += kTile) {
    for (int x = 0; x < size; x += kTile) fillTile(all, triangles, x, y, slice);
  }
  return slice;
}

int mostTellingPlane(const StoredFunction& function) {
  constexpr float kSlab = 0.08f, kThinSlab = 0.03f;  // a wall that ends beside the plane is a wall in it
  constexpr double kEnoughAir = 0.25;
  const std::vector<LocalPoint>& points = supportPattern().points;
  double score[3] = {}, air[3] = {}, count[3] = {};
  for (size_t i = 0; i < points.size(); ++i) {
    const double difference = std::fabs(function.phi[i] / 255.0 - tent(points[i]));
    for (int axis = 0; axis < 3; ++axis) {
      if (std::fabs(points[i][axis]) < kSlab) score[axis] += difference;
      if (std::fabs(points[i][axis]) >= kThinSlab) continue;
      air[axis] += function.isValid(i) ? 1.0 : 0.0;
      count[axis] += 1.0;
    }
  }
  // a plane within a wall differs most, and shows nothing
  for (int axis = 0; axis < 3; ++axis) score[axis] *= std::min(1.0, air[axis] / (kEnoughAir * count[axis]));
  int best = 1;  // the floor plan, unless another plane says clearly more
  for (const int axis : {0, 2}) {
    if (score[axis] > 1.2 * score[best]) best = axis;
  }
  return best;
}

}  // namespace nlg
