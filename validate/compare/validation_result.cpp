#include "validate/compare/validation_result.h"

#include <charconv>
#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kColumns =
    "representation,method,function,scene,hard,rmse,rmse_unseen_points,rmse_shadow,leak_mean,leak_p99,elapsed_us";
constexpr size_t kColumnCount = 11;

// The value at a place like "representations.mlp.generator.rmse.mean"; keys are given one by one, for names may hold dots.
const Json& at(const std::string& path, const Json& json, const std::vector<std::string>& keys) {
  const Json* node = &json;
  std::string place;
  for (const std::string& key : keys) {
    if (!node->is_object() || !node->contains(key)) {
      throw InputError(path, place.empty() ? "top level" : place, "a key '" + key + "'", "none");
    }
    node = &(*node)[key];
    place += (place.empty() ? "" : ".") + key;
  }
  return *node;
}

std::string joined(const std::vector<std::string>& keys) {
  std::string place;
  for (const std::string& key : keys) place += (place.empty() ? "" : ".") + key;
  return place;
}

double number(const std::string& path, const Json& json, const std::vector<std::string>& keys) {
  const Json& value = at(path, json, keys);
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    throw InputError(path, joined(keys), "a finite number", value.dump().substr(0, 40));
  }
  return value.get<double>();
}

const Json& object(const std::string& path, const Json& json, const std::vector<std::string>& keys) {
  const Json& value = at(path, json, keys);
  if (!value.is_object() || value.empty())
    throw InputError(path, joined(keys), "an object with keys", value.dump().substr(0, 40));
  return value;
}

ComparedRepresentation representationOf(const std::string& path, const Json& json, const std::string& name) {
  ComparedRepresentation result;
  result.name = name;
  const auto figure = [&](const char* method, std::vector<std::string> keys) {
    keys.insert(keys.begin(), {"representations", name, method});
    return number(path, json, keys);
  };
  for (const char* method : kComparedMethods) {
    result.figures[method] = {figure(method, {"rmse", "mean"}),   figure(method, {"rmse", "p99"}),
                              figure(method, {"rmse", "worst"}),  figure(method, {"rmse_hard", "mean"}),
                              figure(method, {"share_over_tau"}), figure(method, {"leak", "mean"}),
                              figure(method, {"us_per_function"})};
  }
  for (const auto& [scene, _] : object(path, json, {"representations", name, "by_scene"}).items()) {
    result.scene_rmse[scene] = number(path, json, {"representations", name, "by_scene", scene, "mean"});
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

bool isCompared(const std::string& method) {
  for (const char* compared : kComparedMethods) {
    if (method == compared) return true;
  }
  return false;
}

void readFunctions(const std::string& path, ValidationResult* result) {
  CsvRows rows(path, readFile(path));
  std::vector<std::string> fields;
  const bool has_header = rows.next(&fields);
  std::string header;
  for (const std::string& field : fields) header += (header.empty() ? "" : ",") + field;
  if (!has_header || header != kColumns) throw InputError(path, "row 1", kColumns, header.substr(0, 120));
  while (rows.next(&fields)) {
    if (fields.size() != kColumnCount) {
      throw InputError(path, rows.place(), std::to_string(kColumnCount) + " fields", std::to_string(fields.size()));
    }
    ComparedRepresentation* representation = find(result->representations, fields[0]);
    if (!representation || !isCompared(fields[1])) continue;
    representation->functions[fields[1]].push_back({static_cast<uint64_t>(rows.number(fields[2])), fields[3], fields[4] == "1",
                                                    rows.number(fields[5]), rows.number(fields[8]), rows.number(fields[9])});
  }
}

}  // namespace

ValidationResult readValidation(const std::string& summary_path) {
  const Json json = Json::parse(readFile(summary_path), nullptr, false);
  if (json.is_discarded() || !json.is_object())
    throw InputError(summary_path, "content", "summary.json of nlg-validate", "no JSON object");
  if (const double version = number(summary_path, json, {"schema_version"}); version != 1) {
    throw InputError(summary_path, "schema_version", "1", std::to_string(static_cast<int64_t>(version)));
  }
  ValidationResult result;
  result.path = summary_path;
  const Json& held_out = at(summary_path, json, {"provenance", "inputs", "held_out"});
  if (!held_out.is_string())
    throw InputError(summary_path, "provenance.inputs.held_out", "a text", held_out.dump().substr(0, 40));
  result.held_out = held_out.get<std::string>();
  for (const char* key : {"rmse", "leak_p99", "hard_tent_rmse"}) result.tau[key] = number(summary_path, json, {"tau", key});
  for (const auto& [name, _] : object(summary_path, json, {"representations"}).items()) {
    result.representations.push_back(representationOf(summary_path, json, name));
  }
  const std::string functions = (std::filesystem::path(summary_path).parent_path() / "functions.csv").string();
  result.has_functions = std::filesystem::exists(functions);
  if (!result.has_functions) return result;
  readFunctions(functions, &result);
  for (const ComparedRepresentation& representation : result.representations) {
    for (const char* method : kComparedMethods) {
      const double expected = number(summary_path, json, {"representations", representation.name, method, "functions"});
      const auto rows = representation.functions.find(method);
      const size_t count = rows == representation.functions.end() ? 0 : rows->second.size();
      if (static_cast<double>(count) != expected) {
        throw InputError(functions, "rows of '" + representation.name + "', '" + method + "'",
                         std::to_string(static_cast<int64_t>(expected)) + " as in summary.json", std::to_string(count));
      }
    }
  }
  return result;
}

}  // namespace nlg
