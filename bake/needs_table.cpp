#include <fmt/format.h>

#include "bake/needs.h"

namespace nlg {
namespace {

template <class T>
nlohmann::ordered_json orNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

std::string yesOrNo(const std::optional<bool>& value, const char* yes, const char* no) { return value ? *value ? yes : no : "-"; }

}  // namespace

nlohmann::ordered_json toJson(const std::vector<Need>& needs) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Need& need : needs) {
    rows.push_back({{"what", need.what},
                    {"left_out", orNull(need.left_out)},
                    {"count", need.count},
                    {"of", need.of},
                    {"seconds_saved", orNull(need.seconds_saved)},
                    {"seconds_noise", orNull(need.seconds_noise)},
                    {"bytes_saved", orNull(need.bytes_saved)},
                    {"same_result", orNull(need.same_result)},
                    {"note", need.note}});
  }
  return rows;
}

std::string toTable(const std::vector<Need>& needs) {
  std::string text = fmt::format("{:<56} {:>8} {:>10} {:>10} {:>9} {:>12} {:>7}\n", "not needed", "left out", "count", "of",
                                 "seconds", "bytes", "result");
  for (const Need& need : needs) {
    text += fmt::format(
        "{:<56} {:>8} {:>10} {:>10} {:>9} {:>12} {:>7}  {}\n", need.what, yesOrNo(need.left_out, "yes", "not yet"), need.count,
        need.of, need.seconds_saved ? fmt::format("{:.3f}", *need.seconds_saved) : "-",
        need.bytes_saved ? std::to_string(*need.bytes_saved) : "-", yesOrNo(need.same_result, "same", "differs"), need.note);
  }
  return text;
}

}  // namespace nlg
