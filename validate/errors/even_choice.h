// Which functions of held-out scenes are measured where not all can be.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nlg {

// Functions of all scenes in turn, so that every stretch of the list holds all scenes: of each scene as many as of the others, or
// all that it has, at equal distances.
// scene_idx   N, < scene_count
// wanted      > 0; with fewer than so many functions all are taken
std::vector<uint64_t> chooseEvenly(const std::vector<uint32_t>& scene_idx, size_t scene_count, uint64_t wanted);

}  // namespace nlg
