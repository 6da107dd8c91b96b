// Draws one slice: values, solid, borders, the geometry's cut, the points behind it.
#pragma once

#include <vector>

#include "datagen/view/function_slice.h"
#include "datagen/view/image.h"

namespace nlg {

struct PanelOptions {
  bool with_points = true;    // the support points near the plane as dots, in their own colour
  double cut_width_px = 2.0;  // 0 draws no cut
};

inline constexpr Colour kSeenBorder{255, 84, 60};   // between what the probe sees and what was diffused
inline constexpr Colour kUnknown{226, 226, 232};    // no support point is visible from here
inline constexpr Colour kTwoSidedCut{0, 120, 255};  // cut of a double-sided face: no evidence of solid
inline constexpr double kPointSlab = 0.06;          // support points this near to the plane are drawn, shares of the spacing

// size x size pixels of slice.size.
// triangles   those near the probe in local coordinates; null: no cut is drawn
Image drawSlicePanel(const FunctionSlice& slice, const StoredFunction& function, const std::vector<ViewTriangle>* triangles,
                     const PanelOptions& options);

// Draws what stands for a support point: a disc in the colour of its value, with a white rim when the probe sees it and a red one
// when not; a cross when it is invalid.
void drawSupportPoint(Image& image, const glm::dvec2& at, double phi, PixelKind kind);

// Draws a line of the geometry's cut.
void drawCutLine(Image& image, const glm::dvec2& a, const glm::dvec2& b, double width_px, bool double_sided);

}  // namespace nlg
