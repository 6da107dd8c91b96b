
#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/numbers/logistic.h"

namespace nlg {

void packQuads(int resolution, const int8_t* brick, uint32_t* quads) {
  const int r = resolution;
  for (int z = 0; z + 1 < r; ++z) {
    for (int y = 0; y + 1 < r; ++y) {
      for (int x = 0; x < r; ++x) {
        const int8_t* node = brick + x + r * (y + r * z);
        const auto byte = [&](int offset) { return uint32_t{static_cast<uint8_t>(node[offset])}; };
        // a word holds the nodes of one x, two y and two z: two words in a row are the eight nodes of a cell
        *quads++ = byte(0) | byte(r) << 8 | byte(r * r) << 16 | byte(r * (r + 1)) << 24;
      }
    }
  }
}

float evaluateQuads(int resolution, const LocalPoint& point, float step, const uint32_t* quads) {
  const int r = resolution;
  const NodePlace<float> place = placeAmongNodes(r, point);
  const auto between = [](float near, float far, float at) { return near + at * (far - near); };
  const uint32_t* low = quads + place.node[0] + r * (place.node[1] + (r - 1) * place.node[2]);
  float along_x[4];
  for (int i = 0; i < 4; ++i) {
    const auto nodeOf = [&](uint32_t word) { return static_cast<float>(static_cast<int8_t>(word >> 8 * i)); };
    along_x[i] = between(nodeOf(low[0]), nodeOf(low[1]), place.share[0]);
  }
  const float near = between(along_x[0], along_x[1], place.share[1]), far = between(along_x[2], along_x[3], place.share[1]);
  return logistic(step * between(near, far, place.share[2]));
}

}  // namespace nlg
