#include "datagen/dataset/packed_functions.h"

#include <algorithm>

#include "datagen/dataset/chunk_codec.h"
#include "tool/error.h"

namespace nlg {

PackedFunctions::PackedFunctions(int point_count, const std::string& folder)
    : point_count_(static_cast<size_t>(point_count)),
      file_(folder, "samples of functions, for comparison"),
      samples_(point_count_ / 8 * 9) {}

void PackedFunctions::append(const StoredFunction& function) {
  std::copy_n(function.phi, point_count_, samples_.begin());
  std::copy_n(function.validity, point_count_ / 8, samples_.begin() + static_cast<ptrdiff_t>(point_count_));
  packed_ = encodeChunk(samples_.data(), samples_.size());
  file_.append(packed_.data(), packed_.size());
  ends_.push_back(file_.byteCount());
}

StoredFunction PackedFunctions::at(uint64_t id) {
  NLG_CHECK(id, <, ends_.size());
  const uint64_t first = id == 0 ? 0 : ends_[id - 1];
  packed_.resize(ends_[id] - first);
  file_.read(first, packed_.data(), packed_.size());
  NLG_CHECK(decodeChunk(packed_.data(), packed_.size(), samples_.data(), samples_.size()), ==, true);
  return {samples_.data(), samples_.data() + point_count_};
}

}  // namespace nlg
