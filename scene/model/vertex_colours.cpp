#include "scene/model/vertex_colours.h"

#include <algorithm>

namespace nlg {

float whiteOf(std::vector<float> numbers) {
  numbers.erase(std::remove_if(numbers.begin(), numbers.end(), [](float number) { return !(number > 0.0f); }), numbers.end());
  if (numbers.empty()) return 1.0f;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>((numbers.size() - 1) / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle > 255.0f ? 65535.0f : *middle > 2.0f ? 255.0f : 1.0f;
}

size_t makeShares(float white, std::vector<float>* numbers) {
  size_t cut_count = 0;
  for (float& number : *numbers) {
    number /= white;
    cut_count += number < -0.001f || number > 1.001f ? 1 : 0;
    number = std::clamp(number, 0.0f, 1.0f);
  }
  return cut_count;
}

}  // namespace nlg
