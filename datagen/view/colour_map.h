// Colours of values.
#pragma once

#include "datagen/view/image.h"

namespace nlg {

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

}  // namespace nlg
