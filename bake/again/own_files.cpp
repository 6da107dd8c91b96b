#include "bake/again/own_files.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace nlg {
namespace {

using Json = nlohmann::json;

bool areGrids(std::string_view bytes) {
  return bytes.size() > 8 && bytes.substr(8).starts_with(R"({"__metadata__":{)") && hold(bytes, R"("kind":"nlg-light-grid")");
}

bool areReports(std::string_view bytes) { return bytes.starts_with("{\"scene\":") && hold(bytes, "\"peak_memory_bytes\":"); }

bool areInputs(std::string_view bytes) {
  const Json list = Json::parse(bytes, nullptr, false);
  return list.is_array() && std::all_of(list.begin(), list.end(), [](const Json& entry) { return entry.is_string(); }) &&
         std::is_sorted(list.begin(), list.end()) && list.dump() + "\n" == bytes;
}

}  // namespace

const OwnFiles kGridFiles = {"a light grid", areGrids}, kReportFiles = {"what a bake said of itself", areReports},
               kInputsFiles = {"a list of inputs", areInputs};

}  // namespace nlg
