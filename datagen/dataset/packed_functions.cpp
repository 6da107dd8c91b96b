#include "datagen/dataset/packed_functions.h"

#include <algorithm>

#include "datagen/dataset/chunk_codec.h"
#include "tool/error.h"

namespace nlg {

PackedFunctions::PackedFunctions(int point_count, const std::string& folder)
    : point_count_(static_cast<size_t>(point_count)),
      file_(folder, "samples of functions, for comparison"),
      samples_(point_count_ / 8 * 9) {}

uint64_t PackedFunctions::append(const StoredFunction& function) {
  std::copy_n(function.phi, point_count_, samples_.begin());
  std::copy_n(function.validity, point_count_ / 8, samples_.begin() + static_cast<ptrdiff_t>(point_count_));
  packed_ = encodeChunk(samples_.data(), samples_.size());
  const uint64_t place = file_.byteCount();
  const auto byte_count = static_cast<uint32_t>(packed_.size());
  file_.append(&byte_count, sizeof byte_count);
  file_.append(packed_.data(), packed_.size());
  return place;
}

StoredFunction PackedFunctions::at(uint64_t place) {
  uint32_t byte_count = 0;
  file_.read(place, &byte_count, sizeof byte_count);
  packed_.resize(byte_count);
  file_.read(place + sizeof byte_count, packed_.data(), packed_.size());
  NLG_CHECK(decodeChunk(packed_.data(), packed_.size(), samples_.data(), samples_.size()), ==, true);
  return {samples_.data(), samples_.data() + point_count_};
}

}  // namespace nlg
