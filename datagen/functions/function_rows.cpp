#include "datagen/functions/function_rows.h"

#include <algorithm>

#include "tool/error.h"

namespace nlg {
namespace {

// Calls visit(array, values a function, array of each of the further rows).
template <class Visit, class Rows, class... MoreRows>
void forEachWidth(const Visit& visit, Rows& rows, MoreRows&... more) {
  forEachArray([&](const char*, const std::vector<uint64_t>& columns, auto&... arrays) { visit(rowWidth(columns), arrays...); },
               rows, more...);
}

auto at(auto& values, uint64_t place) { return values.begin() + static_cast<ptrdiff_t>(place); }

}  // namespace

FunctionRows emptyLike(const FunctionRows& rows) {
  FunctionRows empty;
  empty.point_count = rows.point_count;
  empty.test_point_count = rows.test_point_count;
  return empty;
}

StoredFunction functionAt(const FunctionRows& rows, uint64_t n) {
  const auto P = static_cast<uint64_t>(rows.point_count);
  return {&rows.phi[n * P], &rows.validity[n * P / 8], rows.seen.empty() ? nullptr : &rows.seen[n * P / 8],
          rows.blend_sum.empty() ? nullptr : &rows.blend_sum[n * P]};
}

void appendRows(const FunctionRows& from, uint64_t first, uint64_t count, FunctionRows* to) {
  NLG_CHECK(from.point_count, ==, to->point_count);
  NLG_CHECK(from.test_point_count, ==, to->test_point_count);
  forEachWidth(
      [&](uint64_t width, const auto& values, auto& appended) {
        appended.insert(appended.end(), at(values, first * width), at(values, (first + count) * width));
      },
      from, *to);
}

void appendZeros(FunctionRows* rows) {
  forEachWidth([](uint64_t width, auto& values) { values.resize(values.size() + width); }, *rows);
}

void reserveRows(uint64_t count, FunctionRows* rows) {
  forEachWidth([&](uint64_t width, auto& values) { values.reserve(count * width); }, *rows);
}

void moveRow(uint64_t from, uint64_t to, FunctionRows* rows) {
  forEachWidth([&](uint64_t width, auto& values) { std::copy_n(at(values, from * width), width, at(values, to * width)); },
               *rows);
}

void truncateRows(uint64_t count, FunctionRows* rows) {
  forEachWidth([&](uint64_t width, auto& values) { values.resize(count * width); }, *rows);
}

}  // namespace nlg
