#include "datagen/view/legend.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datagen/view/slice_panel.h"

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

double linear(uint8_t channel) {
  const double value = channel / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

constexpr int kKeyWidth = 24, kKeyHeight = 18, kKeyGap = 30;

void fillHatch(Image& box) {
  for (int y = 0; y < box.height(); ++y) {
    for (int x = 0; x < box.width(); ++x) box.set(x, y, hatchColour(x, y));
  }
}

}  // namespace

Colour viridis(double value) { return between(kViridis, kKnotCount, std::clamp(value, 0.0, 1.0)); }

Colour diverging(double value) { return between(kBlueToRed, kStepCount, 0.5 + 0.5 * std::clamp(value, -1.0, 1.0)); }

Colour phiColour(double phi) { return phi <= 0.0 ? kBlack : viridis(phi); }

double lightness(Colour colour) {
  const double luminance = 0.2126 * linear(colour.r) + 0.7152 * linear(colour.g) + 0.0722 * linear(colour.b);
  return luminance <= 216.0 / 24389.0 ? luminance * 24389.0 / 27.0 : 116.0 * std::cbrt(luminance) - 16.0;
}

std::string fixed(double value, int digits) {
  const std::string text = fmt::format("{:.{}f}", value, digits);
  // no minus before what has been rounded to zero
  return text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos ? text.substr(1) : text;
}

std::string percent(double share) { return fixed(100 * share, share < 0.1 ? 1 : 0) + " %"; }

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

int drawKey(Image& image, int x, int y, const std::string& text, const std::function<void(Image& box)>& draw) {
  // drawn apart, so that nothing reaches over the box
  Image box(kKeyWidth, kKeyHeight, kPaper);
  draw(box);
  paste(image, box, x, y);
  drawFrame(image, x, y, kKeyWidth, kKeyHeight, kPaleInk);
  drawText(image, x + kKeyWidth + 8, y, text, kInk);
  return x + kKeyWidth + 8 + textWidth(text) + kKeyGap;
}

int drawLineKey(Image& image, int x, int y, const std::string& text, Colour ground,
                const std::function<void(Image& box, const glm::dvec2& from, const glm::dvec2& to)>& line) {
  return drawKey(image, x, y, text, [&](Image& box) {
    fillRect(box, 0, 0, kKeyWidth, kKeyHeight, ground);
    line(box, {0.0, kKeyHeight / 2.0}, {kKeyWidth, kKeyHeight / 2.0});
  });
}

void drawScaleBar(Image& image, int x, int y, double px_per_m, int max_px) {
  double length_m = std::pow(10.0, std::floor(std::log10(max_px / px_per_m)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * length_m * px_per_m <= max_px) {
      length_m *= factor;
      break;
    }
  }
  const int length_px = static_cast<int>(std::lround(length_m * px_per_m));
  const std::string label = fmt::format("{:g} m", length_m);
  const int width = std::max(length_px, textWidth(label)) + 12;
  fillRect(image, x, y - 34, width, 34, kWhite);
  drawFrame(image, x, y - 34, width, 34, kPaleInk);
  drawText(image, x + 6 + (length_px - textWidth(label)) / 2 * (length_px > textWidth(label)), y - 33, label, kInk);
  fillRect(image, x + 6, y - 10, length_px, 4, kInk);
  for (const int end : {0, length_px - 2}) fillRect(image, x + 6 + end, y - 14, 2, 8, kInk);
}

void drawSliceLegend(Image& image, int x, int y, bool with_cut, bool with_points) {
  // 0 has a colour of its own: leaks are measured where the function is 0
  drawColourBar(image, x, y, 360, "weighting function φ (black: exactly 0)", {"0", "0.25", "0.5", "0.75", "1"},
                [](double value) { return value < 0.012 ? kBlack : phiColour(value); });
  const int first = x + 440;
  const Colour ground = viridis(0.35);
  int at = drawKey(image, first, y, "solid (invalid)", fillHatch);
  at = drawLineKey(image, at, y, "border of what the probe sees", ground,
                   [](Image& box, const auto& a, const auto& b) { drawLine(box, a, b, 1.6, kSeenBorder); });
  // what only a cut through geometry has
  if (with_cut) {
    drawKey(image, at, y, "no support point in sight", [](Image& box) { fillRect(box, 0, 0, kKeyWidth, kKeyHeight, kUnknown); });
    at = first;
    for (const bool double_sided : {false, true}) {
      at = drawLineKey(image, at, y + 32, double_sided ? "cut of a double-sided face" : "cut of a one-sided face", ground,
                       [&](Image& box, const auto& a, const auto& b) {
                         drawLine(box, a, b, 4.0, kWhite);
                         drawCutLine(box, a, b, 2.0, double_sided);
                       });
    }
  }
  if (!with_points) return;
  // what only pictures of a single probe have room for
  at = first;
  const std::pair<PixelKind, const char*> kinds[] = {{PixelKind::seen, "support point, seen"},
                                                     {PixelKind::diffused, "not seen: φ from diffusion"},
                                                     {PixelKind::solid, "invalid"}};
  for (const auto& [kind, text] : kinds) {
    at =
        drawLineKey(image, at, y + 64, text, kind == PixelKind::solid ? Colour{90, 90, 90} : ground,
                    [kind = kind](Image& box, const auto& a, const auto& b) { drawSupportPoint(box, 0.5 * (a + b), 0.6, kind); });
  }
  drawText(image, at, y + 64, "(within " + fixed(kPointSlab, 2) + " spacings of the plane)", kPaleInk);
}

}  // namespace nlg
