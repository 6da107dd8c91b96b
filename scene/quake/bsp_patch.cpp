// Segments of a piece follow from its bend and are powers of two. Outer edges have a number of their own, which depends on
// their control points alone: two patches that share an edge have the same vertices along it.
#include "scene/quake/bsp_patch.h"

#include <algorithm>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint32_t kMaxSegments = 32;

// Point of a quadratic Bézier curve at i / n, n a power of two: the weights are exact, the ends are a and c themselves, and the
// reversed curve gives the same bits.
glm::dvec3 curvePoint(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, uint32_t i, uint32_t n) {
  const double t = static_cast<double>(i) / n;
  const double s = static_cast<double>(n - i) / n;
  return (a * (s * s) + c * (t * t)) + b * (2.0 * s * t);
}

// The chords of n segments leave the curve by |bend| / (4 n²) at most. What of the bend runs along the chord only moves points
// along it.
uint32_t segmentCount(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double tolerance) {
  glm::dvec3 bend = (a + c) - b * 2.0;
  const glm::dvec3 chord = c - a;
  const double length2 = glm::dot(chord, chord);
  if (length2 > 0.0) bend -= chord * (glm::dot(bend, chord) / length2);
  const double bend2 = glm::dot(bend, bend);
  uint32_t n = 1;
  while (n < kMaxSegments && bend2 > 16.0 * tolerance * tolerance * n * n * n * n) n *= 2;
  return n;
}

// One direction of the control grid: line 0 … line_count - 1, each with piece_count curves.
struct Direction {
  uint32_t piece_count = 0, line_count = 0;
  size_t step = 0, line_step = 0;  // between control points of a line, and between lines
};

// Segments of every piece, for the whole grid and along its two outer edges.
struct Segments {
  std::vector<uint32_t> grid, first_edge, last_edge;
};

Segments countSegments(const std::vector<glm::dvec3>& control, const Direction& d, double tolerance) {
  Segments segments;
  for (uint32_t piece = 0; piece < d.piece_count; ++piece) {
    uint32_t most = 1;
    for (uint32_t line = 0; line < d.line_count; ++line) {
      const glm::dvec3* p = &control[line * d.line_step + 2 * piece * d.step];
      const uint32_t n = segmentCount(p[0], p[d.step], p[2 * d.step], tolerance);
      most = std::max(most, n);
      if (line == 0) segments.first_edge.push_back(n);
      if (line + 1 == d.line_count) segments.last_edge.push_back(n);
    }
    segments.grid.push_back(most);
  }
  return segments;
}

// A grid line: which piece it lies in, and where.
struct Station {
  uint32_t piece = 0, i = 0, n = 1;
};

std::vector<Station> stations(const std::vector<uint32_t>& segments) {
  std::vector<Station> all;
  for (uint32_t piece = 0; piece < segments.size(); ++piece) {
    for (uint32_t i = 0; i < segments[piece]; ++i) all.push_back({piece, i, segments[piece]});
  }
  all.push_back({static_cast<uint32_t>(segments.size()) - 1, segments.back(), segments.back()});
  return all;
}

// Of an outer edge with fewer segments than the grid: the station whose vertex stands for station s.
uint32_t edgeStation(const std::vector<Station>& all, const std::vector<uint32_t>& edge_segments, uint32_t s) {
  const uint32_t stride = all[s].n / edge_segments[all[s].piece];
  return s - all[s].i + (all[s].i + stride / 2) / stride * stride;
}

// Values of all control points, curved to the grid's vertices, row by row.
std::vector<glm::dvec3> gridValues(const std::vector<glm::dvec3>& control, uint32_t width, const std::vector<Station>& columns,
                                   const std::vector<Station>& rows) {
  std::vector<glm::dvec3> values;
  values.reserve(columns.size() * rows.size());
  for (const Station& v : rows) {
    for (const Station& u : columns) {
      glm::dvec3 p[3];
      for (size_t k = 0; k < 3; ++k) {
        const glm::dvec3* line = &control[(2 * v.piece + k) * width + 2 * u.piece];
        p[k] = curvePoint(line[0], line[1], line[2], u.i, u.n);
      }
      values.push_back(curvePoint(p[0], p[1], p[2], v.i, v.n));
    }
  }
  return values;
}

}  // namespace

PatchMesh tessellatePatch(const std::vector<glm::dvec3>& control, uint32_t width, uint32_t height, double tolerance,
                          const std::vector<std::vector<glm::dvec3>>& carried) {
  NLG_CHECK(control.size(), ==, size_t{width} * height);
  // edges count for themselves: a neighbouring patch that shares an edge's control points must get the same vertices
  const Segments along = countSegments(control, {(width - 1) / 2, height, 1, width}, tolerance);
  const Segments across = countSegments(control, {(height - 1) / 2, width, width, 1}, tolerance);
  const std::vector<Station> columns = stations(along.grid);
  const std::vector<Station> rows = stations(across.grid);
  const auto column_count = static_cast<uint32_t>(columns.size());
  const auto row_count = static_cast<uint32_t>(rows.size());

  // carried values (coordinates, colours) take the same stations as positions
  PatchMesh mesh;
  mesh.positions = gridValues(control, width, columns, rows);
  for (const std::vector<glm::dvec3>& values : carried) {
    NLG_CHECK(values.size(), ==, control.size());
    mesh.carried.push_back(gridValues(values, width, columns, rows));
  }

  // where an edge needs fewer segments than the inside, its vertices fall together
  const auto vertexAt = [&](uint32_t column, uint32_t row) {
    if (row == 0) column = edgeStation(columns, along.first_edge, column);
    if (row + 1 == row_count) column = edgeStation(columns, along.last_edge, column);
    if (column == 0) row = edgeStation(rows, across.first_edge, row);
    if (column + 1 == column_count) row = edgeStation(rows, across.last_edge, row);
    return row * column_count + column;
  };
  const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
    if (a != b && b != c && c != a) mesh.triangles.emplace_back(a, b, c);
  };
  for (uint32_t row = 0; row + 1 < row_count; ++row) {
    for (uint32_t column = 0; column + 1 < column_count; ++column) {
      const uint32_t a = vertexAt(column, row), b = vertexAt(column + 1, row);
      const uint32_t c = vertexAt(column + 1, row + 1), d = vertexAt(column, row + 1);
      add(a, b, c);
      add(a, c, d);
    }
  }
  return mesh;
}

uint64_t maxPatchTriangles(uint32_t width, uint32_t height) {
  return uint64_t{2} * kMaxSegments * kMaxSegments * ((width - 1) / 2) * ((height - 1) / 2);
}

}  // namespace nlg
