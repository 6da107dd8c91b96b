// Writes pictures as PNG files.
#pragma once

#include <map>
#include <string>

#include "datagen/view/image.h"

namespace nlg {

// By keyword: 1 to 79 letters, digits and spaces.
using PngTexts = std::map<std::string, std::string>;

// Writes the picture, 8 bits RGB, whole or not at all; no time stamp: the same picture and texts give the same bytes.
// texts    UTF-8, for people: one chunk (iTXt, not compressed) each, before the pixels
// throws   OutputError
void writePng(const std::string& path, const Image& image, const PngTexts& texts = {});

}  // namespace nlg
