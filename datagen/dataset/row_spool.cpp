#include "datagen/dataset/row_spool.h"

#include <algorithm>

namespace nlg {

RowSpool::RowSpool(const std::string& folder, int point_count)
    : file_(folder, "samples of functions, for comparison"),
      point_count_(static_cast<size_t>(point_count)),
      row_(2 * point_count_ + point_count_ / 8) {}

void RowSpool::append(const StoredFunction& function) {
  std::copy_n(function.phi, point_count_, row_.begin());
  std::copy_n(function.validity, point_count_ / 8, row_.begin() + static_cast<ptrdiff_t>(point_count_));
  const auto sums = row_.begin() + static_cast<ptrdiff_t>(point_count_ + point_count_ / 8);
  if (function.blend_sum != nullptr) {
    std::copy_n(function.blend_sum, point_count_, sums);
  } else {
    std::fill(sums, row_.end(), uint8_t{255});
  }
  file_.append(row_.data(), row_.size());
}

StoredFunction RowSpool::read(uint64_t n, std::vector<uint8_t>* samples) const {
  samples->resize(row_.size());
  file_.read(n * row_.size(), samples->data(), samples->size());
  return {samples->data(), samples->data() + point_count_, nullptr, samples->data() + point_count_ + point_count_ / 8};
}

}  // namespace nlg
