#include "validate/views/view_pictures.h"

#include <algorithm>

#include <fmt/format.h>

#include "datagen/view/font.h"
#include "datagen/view/legend.h"
#include "render/panel.h"
#include "render/tone.h"

namespace nlg {
namespace {

Image enlarged(const Image& image, int scale) {
  Image large(image.width() * scale, image.height() * scale, kBlack);
  for (int y = 0; y < large.height(); ++y) {
    for (int x = 0; x < large.width(); ++x) large.set(x, y, image.at(x / scale, y / scale));
  }
  return large;
}

std::vector<std::string> captionOf(const ViewFigures& f) {
  return {fmt::format("HyAB {:.1f}, > 2x {:.1f} %", f.colour, 100.0 * (f.off_last.brighter + f.off_last.darker)),
          fmt::format("dim {:.1f} %", 100.0 * f.dim)};
}

}  // namespace

Image viewRow(const std::vector<ShownMethod>& methods, double exposure, const std::vector<std::string>& truth_caption,
              int scale) {
  std::vector<PanelColumn> columns;
  for (size_t m = 0; m < methods.size(); ++m) {
    const std::vector<std::string> caption = m == 0 ? truth_caption : captionOf(methods[m].figures);
    columns.push_back({methods[m].picture.method, caption, enlarged(toneMapped(methods[m].picture, exposure), scale), {}});
  }
  return drawPanel(columns, {});
}

Image contactSheet(const std::vector<Image>& rows, const std::string& heading) {
  constexpr int kMargin = 16, kScale = 2, kHead = kScale * kGlyphHeight + kMargin;
  int width = textWidth(heading, kScale) + 2 * kMargin, height = kMargin + kHead;
  for (const Image& row : rows) {
    width = std::max(width, row.width());
    height += row.height();
  }
  Image sheet(width, height, kPaper);
  drawText(sheet, kMargin, kMargin, heading, kInk, kScale);
  int y = kMargin + kHead;
  for (const Image& row : rows) {
    paste(sheet, row, 0, y);
    y += row.height();
  }
  return sheet;
}

}  // namespace nlg
