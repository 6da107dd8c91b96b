// Pictures as PNG files.
#pragma once

#include <string>

#include "datagen/view/image.h"

namespace nlg {

// Writes the picture, 8 bits RGB, whole or not at all; no time stamp: the same picture gives the same bytes.
// throws   OutputError
void writePng(const std::string& path, const Image& image);

}  // namespace nlg
