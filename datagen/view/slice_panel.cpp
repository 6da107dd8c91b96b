#include "datagen/view/slice_panel.h"

#include <cmath>

#include "datagen/view/legend.h"

namespace nlg {
namespace {

glm::dvec2 pixelOf(const FunctionSlice& slice, const glm::dvec3& local) {
  return 0.5 * slice.size * (slice.plane.fromLocal(local) + 1.0);
}

void drawValues(Image& image, const FunctionSlice& slice) {
  for (int y = 0; y < slice.size; ++y) {
    for (int x = 0; x < slice.size; ++x) {
      const size_t at = static_cast<size_t>(y) * slice.size + x;
      switch (slice.kind[at]) {
        case PixelKind::unknown:
          image.set(x, y, kUnknown);
          break;
        case PixelKind::solid:
          image.set(x, y, hatchColour(x, y));
          break;
        case PixelKind::seen:
        case PixelKind::diffused:
          image.set(x, y, phiColour(slice.phi[at]));
          break;
      }
    }
  }
}

// The line seen_share = 1/2 through the four pixels from (x, y), when all are valid: marching squares.
void drawBorderCell(Image& image, const FunctionSlice& slice, int x, int y) {
  constexpr int kCorners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  double share[4];
  for (int i = 0; i < 4; ++i) {
    const size_t at = static_cast<size_t>(y + kCorners[i][1]) * slice.size + x + kCorners[i][0];
    if (slice.kind[at] != PixelKind::seen && slice.kind[at] != PixelKind::diffused) return;
    share[i] = slice.seen_share[at] - 0.5;
  }
  glm::dvec2 crossing[4];
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    if ((share[i] >= 0) == (share[j] >= 0)) continue;
    const double t = share[i] / (share[i] - share[j]);
    const glm::dvec2 a(kCorners[i][0], kCorners[i][1]), b(kCorners[j][0], kCorners[j][1]);
    crossing[count++] = glm::dvec2(x + 0.5, y + 0.5) + a + t * (b - a);
  }
  for (int i = 0; i + 1 < count; i += 2) drawLine(image, crossing[i], crossing[i + 1], 1.6, kSeenBorder);
}

void drawPoints(Image& image, const FunctionSlice& slice, const StoredFunction& function) {
  const std::vector<LocalPoint>& points = supportPattern().points;
  for (size_t i = 0; i < points.size(); ++i) {
    if (std::fabs(points[i][slice.plane.normal]) > kPointSlab) continue;
    const glm::dvec3 local(points[i][0], points[i][1], points[i][2]);
    const PixelKind kind = !function.isValid(i) ? PixelKind::solid : function.isSeen(i) ? PixelKind::seen : PixelKind::diffused;
    drawSupportPoint(image, pixelOf(slice, local), function.phi[i] / 255.0, kind);
  }
}

}  // namespace

void drawSupportPoint(Image& image, const glm::dvec2& at, double phi, PixelKind kind) {
  if (kind == PixelKind::solid) {
    for (const double sign : {-1.0, 1.0})
      drawLine(image, at - glm::dvec2(2.4, 2.4 * sign), at + glm::dvec2(2.4, 2.4 * sign), 1.2, kWhite);
    return;
  }
  drawDisc(image, at, 3.6, kind == PixelKind::seen ? kWhite : kSeenBorder);
  drawDisc(image, at, 2.6, phiColour(phi));
}

void drawCutLine(Image& image, const glm::dvec2& a, const glm::dvec2& b, double width_px, bool double_sided) {
  drawLine(image, a, b, width_px, double_sided ? kTwoSidedCut : kBlack);
}

Image drawSlicePanel(const FunctionSlice& slice, const StoredFunction& function, const std::vector<ViewTriangle>* triangles,
                     const PanelOptions& options) {
  Image image(slice.size, slice.size, kUnknown);
  drawValues(image, slice);
  for (int y = 0; y + 1 < slice.size; ++y) {
    for (int x = 0; x + 1 < slice.size; ++x) drawBorderCell(image, slice, x, y);
  }
  if (triangles != nullptr && options.cut_width_px > 0) {
    const std::vector<CutSegment> cut = cutTriangles(*triangles, slice.plane.normal, 0.0);
    // all rims first: a line's rim must not cut through its neighbour
    for (const CutSegment& s : cut) drawLine(image, pixelOf(slice, s.a), pixelOf(slice, s.b), options.cut_width_px + 2, kWhite);
    for (const CutSegment& s : cut) {
      drawCutLine(image, pixelOf(slice, s.a), pixelOf(slice, s.b), options.cut_width_px, s.double_sided);
    }
  }
  if (options.with_points) drawPoints(image, slice, function);
  return image;
}

}  // namespace nlg
