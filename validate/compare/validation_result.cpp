#include "validate/compare/validation_result.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

using Place = Json::json_pointer;

constexpr const char* kColumns =
    "representation,word,function,scene,take_theta,hard,rmse,rmse_test_points,rmse_occluded,leak_mean,leak_p99,fails_check,"
    "fitted,elapsed_us";
constexpr size_t kColumnCount = 14;

// A place as "/representations/mlp/stored/theta": its steps are given one by one, for names may hold slashes and dots.
Place placeOf(std::initializer_list<std::string> steps) {
  Place place;
  for (const std::string& step : steps) place /= step;
  return place;
}

const Json& at(const std::string& path, const Json& json, const Place& place) {
  try {
    return json.at(place);
  } catch (const Json::exception&) {
    throw InputError(path, place.to_string(), "a value", "none");
  }
}

double number(const std::string& path, const Json& json, const Place& place) {
  const Json& value = at(path, json, place);
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    throw InputError(path, place.to_string(), "a finite number", value.dump().substr(0, 40));
  }
  return value.get<double>();
}

std::string text(const std::string& path, const Json& json, const Place& place) {
  const Json& value = at(path, json, place);
  if (!value.is_string()) throw InputError(path, place.to_string(), "a text", value.dump().substr(0, 40));
  return value.get<std::string>();
}

const Json& object(const std::string& path, const Json& json, const Place& place) {
  const Json& value = at(path, json, place);
  if (!value.is_object() || value.empty())
    throw InputError(path, place.to_string(), "an object with keys", value.dump().substr(0, 40));
  return value;
}

ComparedRepresentation representationOf(const std::string& path, const Json& json, const std::string& name) {
  ComparedRepresentation result;
  result.name = name;
  const Place whole = placeOf({"representations", name});
  for (const char* word : kComparedWords) {
    const Place theta = whole / std::string(word) / "theta", hard = whole / std::string(word) / "hard";
    const auto figure = [&](const Place& place) { return number(path, json, place); };
    result.figures[word] = {.rmse = figure(theta / "rmse" / "mean"),
                            .rmse_p99 = figure(theta / "rmse" / "p99"),
                            .rmse_worst = figure(theta / "rmse" / "worst"),
                            .rmse_hard = figure(hard / "rmse" / "mean"),
                            .share_failing_check = figure(theta / "share_failing_check" / "value"),
                            .share_fitted = figure(theta / "share_fitted" / "value"),
                            .leak_mean = figure(theta / "leak" / "mean"),
                            .us_per_function = figure(theta / "us_per_function")};
  }
  for (const auto& [scene, _] : object(path, json, whole / "by_scene").items()) {
    for (const char* word : kWordsByScene)
      result.scene_rmse[scene][word] = number(path, json, whole / "by_scene" / scene / std::string(word) / "mean");
  }
  return result;
}

// Reads a CSV text row by row, fields as RFC 4180 quotes them.
class CsvRows {
 public:
  CsvRows(std::string path, std::string text) : path_(std::move(path)), text_(std::move(text)) {}

  // The next row's fields, or nothing at the end.
  bool next(std::vector<std::string>* fields) {
    if (position_ >= text_.size()) return false;
    ++row_;
    fields->assign(1, "");
    bool is_quoted = false;
    for (; position_ < text_.size(); ++position_) {
      const char c = text_[position_];
      if (is_quoted && c == '"' && position_ + 1 < text_.size() && text_[position_ + 1] == '"') {
        fields->back() += text_[++position_];
      } else if (c == '"') {
        is_quoted = !is_quoted;
      } else if (c == ',' && !is_quoted) {
        fields->emplace_back();
      } else if (c == '\n' && !is_quoted) {
        break;
      } else {
        fields->back() += c;
      }
    }
    if (is_quoted) throw InputError(path_, place(), "a closing quotation mark", "the end of the file");
    ++position_;
    return true;
  }

  std::string place() const { return "row " + std::to_string(row_); }

  double number(const std::string& text) const {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      throw InputError(path_, place(), "a finite number", "'" + text.substr(0, 40) + "'");
    }
    return value;
  }

 private:
  std::string path_, text_;
  size_t position_ = 0, row_ = 0;
};

ComparedRepresentation* find(std::vector<ComparedRepresentation>& all, const std::string& name) {
  for (ComparedRepresentation& representation : all) {
    if (representation.name == name) return &representation;
  }
  return nullptr;
}

bool isCompared(const std::string& word) {
  return std::find(std::begin(kComparedWords), std::end(kComparedWords), word) != std::end(kComparedWords);
}

void readFunctions(const std::string& path, ValidationResult* result) {
  CsvRows rows(path, readFile(path));
  std::vector<std::string> fields;
  const bool has_header = rows.next(&fields);
  if (!has_header || fmt::format("{}", fmt::join(fields, ",")) != kColumns)
    throw InputError(path, "row 1", kColumns, fmt::format("{}", fmt::join(fields, ",")).substr(0, 120));
  while (rows.next(&fields)) {
    if (fields.size() != kColumnCount) {
      throw InputError(path, rows.place(), std::to_string(kColumnCount) + " fields", std::to_string(fields.size()));
    }
    ComparedRepresentation* representation = find(result->representations, fields[0]);
    if (!representation || !isCompared(fields[1])) continue;
    representation->functions[fields[1]].push_back({.function = static_cast<uint64_t>(rows.number(fields[2])),
                                                    .scene = fields[3],
                                                    .takes_theta = fields[4] == "1",
                                                    .hard = fields[5] == "1",
                                                    .rmse = rows.number(fields[6]),
                                                    .leak_mean = rows.number(fields[9]),
                                                    .fails_check = fields[11] == "1"});
  }
}

}  // namespace

ValidationResult readValidation(const std::string& summary_path) {
  const Json json = Json::parse(readFile(summary_path), nullptr, false);
  if (json.is_discarded() || !json.is_object())
    throw InputError(summary_path, "content", "summary.json of nlg-validate", "no JSON object");
  if (const double version = number(summary_path, json, placeOf({"schema_version"})); version != kComparedSchemaVersion) {
    throw InputError(summary_path, "schema_version",
                     fmt::format("{}: results are compared with those of the same schema only", kComparedSchemaVersion),
                     fmt::format("{:g}", version));
  }
  ValidationResult result;
  result.path = summary_path;
  result.held_out = text(summary_path, json, placeOf({"provenance", "inputs", "held_out"}));
  result.theta_precision = text(summary_path, json, placeOf({"theta_precision"}));
  for (const char* key : {"rmse", "leak", "leak_share", "hard_tent_rmse", "bare_tent_rmse"})
    result.tau[key] = number(summary_path, json, placeOf({"tau", key}));
  for (const auto& [name, _] : object(summary_path, json, placeOf({"representations"})).items()) {
    result.representations.push_back(representationOf(summary_path, json, name));
  }
  const std::string functions = (std::filesystem::path(summary_path).parent_path() / "functions.csv").string();
  result.has_functions = std::filesystem::exists(functions);
  if (!result.has_functions) return result;
  readFunctions(functions, &result);
  for (ComparedRepresentation& representation : result.representations) {
    for (const char* word : kComparedWords) {
      const double expected =
          number(summary_path, json, placeOf({"representations", representation.name, word, "all", "functions"}));
      const size_t count = representation.functions[word].size();
      if (static_cast<double>(count) != expected) {
        throw InputError(functions, "rows of '" + representation.name + "', '" + word + "'",
                         fmt::format("{:g} as in summary.json", expected), std::to_string(count));
      }
    }
  }
  return result;
}

}  // namespace nlg
