// The page of nlg-view, as built by viewer/page/ and compiled into the tool.
#pragma once

#include <array>
#include <string_view>

namespace nlg {

struct PageFile {
  std::string_view name, text;
};
// index.html last: a folder that has it is whole.
std::array<PageFile, 2> pageFiles();

}  // namespace nlg
