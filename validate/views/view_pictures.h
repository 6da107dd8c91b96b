// Pictures for people: one view by several methods in a row, and all views of a scene on one sheet.
#pragma once

#include <string>
#include <vector>

#include "datagen/view/image.h"
#include "render/lit_picture.h"
#include "validate/views/view_figures.h"

namespace nlg {

struct ShownMethod {
  LitPicture picture;   // its method is the title
  ViewFigures figures;  // none are written below truth
};

// Each pixel of the pictures becomes a square of scale x scale.
// methods         truth first
// truth_caption   lines below truth
Image viewRow(const std::vector<ShownMethod>& methods, double exposure, const std::vector<std::string>& truth_caption, int scale);

// Rows below one another.
Image contactSheet(const std::vector<Image>& rows, const std::string& heading);

}  // namespace nlg
