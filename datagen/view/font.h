// A fixed-width bitmap font for pictures: ASCII and the signs ° · × φ.
#pragma once

#include <array>
#include <cstdint>

namespace nlg {

inline constexpr int kGlyphWidth = 9, kGlyphHeight = 18;

// One glyph from top to bottom; bit x of a row is the pixel x from the left. A sign that the font lacks is a question mark.
const std::array<uint16_t, kGlyphHeight>& glyphRows(uint32_t code_point);

}  // namespace nlg
