// Colours of vertices, as programs write them: shares of white, or codes.
#pragma once

#include <cstddef>
#include <vector>

namespace nlg {

// What stands for white: 1; 255 or 65535, if more than half of all numbers above 0 lie above 2 or 255. No few numbers decide, and artists
// make colours brighter than white.
float whiteOf(std::vector<float> numbers);

// Divides by white, and brings into 0 to 1; what is no number stays.
// returns   how many were outside by more than rounding
size_t makeShares(float white, std::vector<float>* numbers);

}  // namespace nlg
