#include "validate/errors/even_choice.h"

#include <algorithm>

namespace nlg {

std::vector<uint64_t> chooseEvenly(const std::vector<uint32_t>& scene_idx, size_t scene_count, uint64_t wanted) {
  std::vector<std::vector<uint64_t>> of_scene(scene_count);
  for (uint64_t i = 0; i < scene_idx.size(); ++i) of_scene[scene_idx[i]].push_back(i);
  // one more of every scene that has more, until there are enough
  std::vector<uint64_t> share(scene_count, 0);
  uint64_t total = 0;
  wanted = std::min<uint64_t>(wanted, scene_idx.size());
  while (total < wanted) {
    for (size_t s = 0; s < scene_count && total < wanted; ++s) {
      if (share[s] < of_scene[s].size()) ++share[s], ++total;
    }
  }
  std::vector<uint64_t> chosen;
  for (uint64_t turn = 0; chosen.size() < wanted; ++turn) {
    for (size_t s = 0; s < scene_count; ++s) {
      if (turn < share[s]) chosen.push_back(of_scene[s][turn * of_scene[s].size() / share[s]]);
    }
  }
  return chosen;
}

}  // namespace nlg
