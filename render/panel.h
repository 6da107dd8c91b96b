// Draws one view by several methods, side by side, with their errors below.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/picture/image.h"
#include "render/tone.h"

namespace nlg {

struct PanelColumn {
  std::string title;                  // the method's name
  std::vector<std::string> captions;  // lines below the picture
  Image picture;
  std::optional<Image> error;  // of the picture's size; none for truth itself
};

struct PanelText {
  std::vector<std::string> heading;  // lines above everything; the first is larger
  ErrorKind kind = ErrorKind::with_sign;
  double range = 0.0;  // of the errors; 0 when there are none
};

// columns   at least one, pictures of one size
Image drawPanel(const std::vector<PanelColumn>& columns, const PanelText& text);

// A single map with its colour bar below.
Image withErrorBar(const Image& map, ErrorKind kind, double range);

}  // namespace nlg
