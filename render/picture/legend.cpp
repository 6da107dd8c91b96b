#include "render/picture/legend.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

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

constexpr int kStepCount = 11;
constexpr Colour kBlueToRed[kStepCount] = {{5, 48, 97},     {33, 102, 172},  {67, 147, 195},  {146, 197, 222},
                                           {209, 229, 240}, {247, 247, 247}, {253, 219, 199}, {244, 165, 130},
                                           {214, 96, 77},   {178, 24, 43},   {103, 0, 31}};

// The colour of a table whose entries stand at even distances. at   in [0, 1]
Colour between(const Colour* knots, int count, double at) {
  const double knot = at * (count - 1);
  const int low = std::min(static_cast<int>(knot), count - 2);
  return mix(knots[low], knots[low + 1], knot - low);
}

// "3.14": a number with so many digits behind the point.
std::string fixed(double value, int digits) {
  const std::string text = fmt::format("{:.{}f}", value, digits);
  // no minus before what has been rounded to zero
  return text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos ? text.substr(1) : text;
}

}  // namespace

Colour viridis(double value) { return between(kViridis, kKnotCount, std::clamp(value, 0.0, 1.0)); }

Colour diverging(double value) { return between(kBlueToRed, kStepCount, 0.5 + 0.5 * std::clamp(value, -1.0, 1.0)); }

std::string positionText(const glm::dvec3& p) {
  return "(" + fixed(p.x, 3) + ", " + fixed(p.y, 3) + ", " + fixed(p.z, 3) + ") m";
}

void drawColourBar(Image& image, int x, int y, int width, const std::string& title, const std::vector<std::string>& labels,
                   const std::function<Colour(double)>& colour) {
  constexpr int kBarHeight = 18;
  drawText(image, x, y, title, kInk);
  const int top = y + kGlyphHeight + 4;
  for (int i = 0; i < width; ++i) fillRect(image, x + i, top, 1, kBarHeight, colour((i + 0.5) / width));
  drawFrame(image, x, top, width, kBarHeight, kPaleInk);
  for (size_t i = 0; i < labels.size(); ++i) {
    const int at = x + static_cast<int>(std::lround(static_cast<double>(width - 1) * i / (labels.size() - 1)));
    fillRect(image, at, top + kBarHeight, 1, 5, kInk);
    drawText(image, at - textWidth(labels[i]) / 2, top + kBarHeight + 6, labels[i], kInk);
  }
}

}  // namespace nlg
