#include "render/panel.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/picture/legend.h"

namespace nlg {
namespace {

constexpr int kMargin = 16, kGap = 10, kLine = kGlyphHeight + 4, kTitleLine = 2 * kGlyphHeight + 8, kBarHeight = 70;

int headingHeight(const PanelText& text) {
  return text.heading.empty() ? 0 : kTitleLine + static_cast<int>(text.heading.size() - 1) * kLine + kGap;
}

// As large as fits.
void drawTitle(Image& image, int x, int y, int width, const std::string& text) {
  const int scale = textWidth(text, 2) <= width ? 2 : 1;
  drawText(image, x, y + (scale == 1 ? kGlyphHeight / 2 : 0), text, kInk, scale);
}

void drawErrorBar(Image& image, int x, int y, int width, ErrorKind kind, double range) {
  const std::string label = fmt::format("{:g}", range), half = fmt::format("{:g}", 0.5 * range);
  if (kind == ErrorKind::with_sign) {
    drawColourBar(image, x, y, width, "error over truth's RMS", {"-" + label, "0", "+" + label},
                  [](double at) { return diverging(2.0 * at - 1.0); });
  } else {
    drawColourBar(image, x, y, width, "|error| over truth's RMS", {"0", half, label}, [](double at) { return viridis(at); });
  }
}

}  // namespace

Image withErrorBar(const Image& map, ErrorKind kind, double range) {
  Image image(map.width() + 2 * kMargin, map.height() + 2 * kMargin + kGap + kBarHeight, kPaper);
  paste(image, map, kMargin, kMargin);
  drawErrorBar(image, kMargin + map.width() / 8, kMargin + map.height() + kGap, map.width() - map.width() / 4, kind, range);
  return image;
}

Image drawPanel(const std::vector<PanelColumn>& columns, const PanelText& text) {
  const int width = columns.front().picture.width(), height = columns.front().picture.height();
  const auto count = static_cast<int>(columns.size());
  // all columns take the caption height of the longest
  size_t caption_lines = 0;
  int pitch = width;  // of columns: captions of small pictures need more than these
  for (const PanelColumn& column : columns) {
    caption_lines = std::max(caption_lines, column.captions.size());
    for (const std::string& caption : column.captions) pitch = std::max(pitch, textWidth(caption));
  }
  // a second row for errors only if a column has one
  const bool has_errors = std::any_of(columns.begin(), columns.end(), [](const PanelColumn& c) { return c.error.has_value(); });
  const int captions = kGap / 2 + static_cast<int>(caption_lines) * kLine;
  const int row = kTitleLine + height + captions;
  int widest = count * pitch + (count - 1) * kGap;
  for (size_t i = 0; i < text.heading.size(); ++i) widest = std::max(widest, textWidth(text.heading[i], i == 0 ? 2 : 1));
  const int total_width = 2 * kMargin + widest;
  const int total_height = 2 * kMargin + headingHeight(text) + row + (has_errors ? height + kGap + kBarHeight : 0);
  // headings above, the first twice as large
  Image panel(total_width, total_height, kPaper);
  for (size_t i = 0; i < text.heading.size(); ++i) {
    const int y = i == 0 ? kMargin : kMargin + kTitleLine + static_cast<int>(i - 1) * kLine;
    drawText(panel, kMargin, y, text.heading[i], kInk, i == 0 ? 2 : 1);
  }
  // column by column: title, picture, captions, error with its bar
  for (int c = 0; c < count; ++c) {
    const PanelColumn& column = columns[c];
    const int x = kMargin + c * (pitch + kGap);
    int y = kMargin + headingHeight(text);
    drawTitle(panel, x, y, width, column.title);
    y += kTitleLine;
    paste(panel, column.picture, x, y);
    for (size_t i = 0; i < column.captions.size(); ++i)
      drawText(panel, x, y + height + kGap / 2 + static_cast<int>(i) * kLine, column.captions[i], kPaleInk);
    y += height + captions;
    if (column.error) {
      paste(panel, *column.error, x, y);
      drawErrorBar(panel, x + width / 8, y + height + kGap, width - width / 4, text.kind, text.range);
    }
  }
  return panel;
}

}  // namespace nlg
