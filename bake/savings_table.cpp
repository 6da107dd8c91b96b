#include <fmt/format.h>

#include "bake/savings.h"

namespace nlg {
namespace {

template <class T>
nlohmann::ordered_json orNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

std::string yesOrNo(const std::optional<bool>& value, const char* yes, const char* no) { return value ? *value ? yes : no : "-"; }

}  // namespace

nlohmann::ordered_json toJson(const std::vector<Saving>& savings) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Saving& saving : savings) {
    rows.push_back({{"what", saving.what},
                    {"left_out", orNull(saving.left_out)},
                    {"count", saving.count},
                    {"of", saving.of},
                    {"seconds_saved", orNull(saving.seconds_saved)},
                    {"seconds_noise", orNull(saving.seconds_noise)},
                    {"bytes_saved", orNull(saving.bytes_saved)},
                    {"same_result", orNull(saving.same_result)},
                    {"note", saving.note}});
  }
  return rows;
}

std::string toTable(const std::vector<Saving>& savings) {
  std::string text = fmt::format("{:<56} {:>8} {:>10} {:>10} {:>9} {:>12} {:>7}\n", "saving", "left out", "count", "of",
                                 "seconds", "bytes", "result");
  for (const Saving& saving : savings) {
    text += fmt::format("{:<56} {:>8} {:>10} {:>10} {:>9} {:>12} {:>7}  {}\n", saving.what,
                        yesOrNo(saving.left_out, "yes", "not yet"), saving.count, saving.of,
                        saving.seconds_saved ? fmt::format("{:.3f}", *saving.seconds_saved) : "-",
                        saving.bytes_saved ? std::to_string(*saving.bytes_saved) : "-",
                        yesOrNo(saving.same_result, "same", "differs"), saving.note);
  }
  return text;
}

}  // namespace nlg
