#include "runtime_eval/numbers/coded_bytes.h"

#include <algorithm>

#include "runtime_eval/numbers/range_coder.h"

namespace nlg {
namespace {

constexpr int kByteBits = 8, kCountBytes = 4;

std::vector<NumberModel> modelsOf(const std::vector<uint16_t>& columns) {
  const size_t last = columns.empty() ? 0 : *std::max_element(columns.begin(), columns.end());
  return std::vector<NumberModel>(last + 1, NumberModel(kByteBits));
}

}  // namespace

std::vector<uint8_t> codedBytes(const std::vector<uint8_t>& bytes, const std::vector<uint16_t>& columns) {
  if (bytes.empty()) return {};
  RangeEncoder encoder;
  NumberModel of_count(kByteBits);
  for (int i = 0; i < kCountBytes; ++i) encoder.add(static_cast<uint32_t>(bytes.size() >> kByteBits * i & 0xff), &of_count);
  std::vector<NumberModel> models = modelsOf(columns);
  for (size_t i = 0; i < bytes.size(); ++i) encoder.add(uint32_t{bytes[i]}, &models[columns.empty() ? 0 : columns[i]]);
  return encoder.finish();
}

bool decodeBytes(const std::vector<uint8_t>& coded, const std::vector<uint16_t>& columns, std::vector<uint8_t>* bytes,
                 size_t most) {
  bytes->clear();
  if (coded.empty()) return columns.empty();
  RangeDecoder decoder(coded.data(), coded.size());
  NumberModel of_count(kByteBits);
  size_t count = 0;
  for (int i = 0; i < kCountBytes; ++i) count |= size_t{decoder.next(&of_count)} << kByteBits * i;
  bool is_right = count > 0 && count <= most && (columns.empty() || columns.size() == count);
  std::vector<NumberModel> models = modelsOf(columns);
  // what the bytes that are there cannot say is not made
  for (size_t i = 0; i < count && is_right; ++i) {
    bytes->push_back(static_cast<uint8_t>(decoder.next(&models[columns.empty() ? 0 : columns[i]])));
    is_right = !decoder.isBeyondEnd();
  }
  is_right = is_right && decoder.isAtEnd();
  if (!is_right) bytes->clear();
  return is_right;
}

}  // namespace nlg
