// A picture in memory, 8 bits per channel, with drawing functions.
//
// Coordinates are pixels, x to the right and y down; (0, 0) is the upper left corner of the first pixel, whose centre is
// (0.5, 0.5). Whatever lies outside the picture is cut off. Lines have smooth edges: a pixel takes the share of the colour by its
// distance from the edge.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "tool/output_path.h"

namespace nlg {

// A fixed-width bitmap font: ASCII and the signs ° · × φ.
inline constexpr int kGlyphWidth = 9, kGlyphHeight = 18;

// One glyph from top to bottom; bit x of a row is the pixel x from the left. A sign that the font lacks is a question mark.
std::array<uint16_t, kGlyphHeight> glyphRows(uint32_t code_point);

struct Colour {
  uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Colour&) const = default;
};

inline constexpr Colour kBlack{0, 0, 0}, kWhite{255, 255, 255};

// share 0 gives a, share 1 gives b
Colour mix(Colour a, Colour b, double share);

class Image {
 public:
  // width, height   >= 1
  Image(int width, int height, Colour background);

  int width() const { return width_; }
  int height() const { return height_; }
  const std::vector<uint8_t>& bytes() const { return bytes_; }  // height x width x 3, row by row from the top

  Colour at(int x, int y) const;  // inside the picture
  void set(int x, int y, Colour colour);
  void blend(int x, int y, Colour colour, double share);

 private:
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

  int width_, height_;
  std::vector<uint8_t> bytes_;
};

// The rectangle of whole pixels from (x, y).
void fillRect(Image& image, int x, int y, int width, int height, Colour colour);

// Dark stripes at 45 degrees over a lighter ground, in step over the whole picture: what lies in solid.
Colour hatchColour(int x, int y);

// A frame of one pixel just outside the rectangle.
void drawFrame(Image& image, int x, int y, int width, int height, Colour colour);

// width_px   of the stroke; ends are round: a line without length is a disc
void drawLine(Image& image, const glm::dvec2& a, const glm::dvec2& b, double width_px, Colour colour);

// UTF-8 text in the font above; (x, y) is its upper left corner.
// scale   >= 1; enlarges by whole pixels, and above 1 thickens the strokes by one pixel
void drawText(Image& image, int x, int y, const std::string& text, Colour colour, int scale = 1);
int textWidth(const std::string& text, int scale = 1);

// Copies a picture onto another, its upper left corner at (x, y).
void paste(Image& image, const Image& inset, int x, int y);

// Of our tools, by the text Software.
inline constexpr OwnFiles kPictures = {"a picture of nlg-render or nlg-validate", [](std::string_view bytes) {
                                         return hold(bytes, "nlg-render") || hold(bytes, "nlg-validate");
                                       }};

// By keyword: 1 to 79 letters, digits and spaces.
using PngTexts = std::map<std::string, std::string>;

// Writes the picture, 8 bits RGB, whole or not at all; no time stamp: the same picture and texts give the same bytes.
// texts    UTF-8, for people: one chunk (iTXt, not compressed) each, before the pixels
// throws   OutputError
void writePng(const std::string& path, const Image& image, const PngTexts& texts = {});

}  // namespace nlg
