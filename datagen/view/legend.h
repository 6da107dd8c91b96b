// Legends of pictures: colour bars, keys, scale bars, numbers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "datagen/view/image.h"

namespace nlg {

// Colours of values.
//
// Viridis (van der Walt & Smith 2015, CC0): perceptually uniform, lightness rises with the value.
// value   clamped to [0, 1]
Colour viridis(double value);

// Red to blue over white (ColorBrewer's RdBu in 11 steps, Cynthia Brewer, Apache 2.0), turned: blue below 0, red above.
// value   clamped to [-1, 1]
Colour diverging(double value);

// The colour of a weighting function's value: black where it is exactly 0, so that the smallest leak stands out against none;
// viridis above.
Colour phiColour(double phi);

// CIE lightness L* of a colour, 0 to 100.
double lightness(Colour colour);

inline constexpr Colour kInk{20, 20, 28}, kPaleInk{96, 96, 108}, kPaper{255, 255, 255}, kWarning{190, 30, 20};

// "3.14": a number with so many digits behind the point.
std::string fixed(double value, int digits);
std::string percent(double share);  // "42 %"; "0.3 %" below 10 %
std::string positionText(const glm::dvec3& position_m);

// A bar of colours from left (0) to right (1), labels below it at even distances.
void drawColourBar(Image& image, int x, int y, int width, const std::string& title, const std::vector<std::string>& labels,
                   const std::function<Colour(double)>& colour);

// A box of 24 x 18 px that `draw` fills, and a text to its right. Returns the x behind both, with a gap.
int drawKey(Image& image, int x, int y, const std::string& text, const std::function<void(Image& box)>& draw);
// The same: a line across a ground of one colour.
int drawLineKey(Image& image, int x, int y, const std::string& text, Colour ground,
                const std::function<void(Image& box, const glm::dvec2& from, const glm::dvec2& to)>& line);

// A bar of 1, 2 or 5 times a power of ten metres, at most max_px long, its lower left corner at (x, y); white on dark, so that it
// can stand on any ground.
void drawScaleBar(Image& image, int x, int y, double px_per_m, int max_px);

// The keys of slice panels: colour bar of phi, solid, seen border, cut, points. Takes 96 px of height and at least 1500 of width.
void drawSliceLegend(Image& image, int x, int y, bool with_cut, bool with_points);

}  // namespace nlg
