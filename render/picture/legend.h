// Legends of pictures: colours of values, colour bars, positions.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "render/picture/image.h"

namespace nlg {

// Colours of values.
//
// Viridis (van der Walt & Smith 2015, CC0): perceptually uniform, lightness rises with the value.
// value   clamped to [0, 1]
Colour viridis(double value);

// Red to blue over white (ColorBrewer's RdBu in 11 steps, Cynthia Brewer, Apache 2.0), turned: blue below 0, red above.
// value   clamped to [-1, 1]
Colour diverging(double value);

inline constexpr Colour kInk{20, 20, 28}, kPaleInk{96, 96, 108}, kPaper{255, 255, 255};

// "(1.000, 2.500, -3.000) m"
std::string positionText(const glm::dvec3& position_m);

// A bar of colours from left (0) to right (1), labels below it at even distances.
void drawColourBar(Image& image, int x, int y, int width, const std::string& title, const std::vector<std::string>& labels,
                   const std::function<Colour(double)>& colour);

}  // namespace nlg
