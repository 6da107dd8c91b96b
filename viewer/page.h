// The page itself, as viewer/page/ builds it: the same for all levels, and part of the tool.
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
