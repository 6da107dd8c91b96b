#include "datagen/view/colour_map.h"

#include <algorithm>
#include <cmath>

namespace nlg {
namespace {

// every eighth entry of the published table of 256, ends included
constexpr int kKnotCount = 33;
constexpr Colour kViridis[kKnotCount] = {
    {68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},  {69, 55, 129},  {66, 64, 134},
    {62, 73, 137},  {59, 82, 139},  {55, 91, 141},  {51, 99, 141},  {47, 107, 142}, {44, 114, 142}, {41, 122, 142},
    {38, 130, 142}, {35, 137, 142}, {33, 145, 140}, {31, 152, 139}, {31, 160, 136}, {34, 167, 133}, {40, 174, 128},
    {50, 182, 122}, {63, 188, 115}, {78, 195, 107}, {94, 201, 98},  {112, 207, 87}, {132, 212, 75}, {152, 216, 62},
    {173, 220, 48}, {194, 223, 35}, {216, 226, 25}, {236, 229, 27}, {253, 231, 37}};

double linear(uint8_t channel) {
  const double value = channel / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

}  // namespace

Colour viridis(double value) {
  const double at = std::clamp(value, 0.0, 1.0) * (kKnotCount - 1);
  const int knot = std::min(static_cast<int>(at), kKnotCount - 2);
  return mix(kViridis[knot], kViridis[knot + 1], at - knot);
}

Colour phiColour(double phi) { return phi <= 0.0 ? kBlack : viridis(phi); }

double lightness(Colour colour) {
  const double luminance = 0.2126 * linear(colour.r) + 0.7152 * linear(colour.g) + 0.0722 * linear(colour.b);
  return luminance <= 216.0 / 24389.0 ? luminance * 24389.0 / 27.0 : 116.0 * std::cbrt(luminance) - 16.0;
}

}  // namespace nlg
