#include "bake/again/own_files.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace nlg {
namespace {

using Json = nlohmann::json;

template <const char* kKind>
bool areTensorsOf(std::string_view bytes) {
  return bytes.size() > 8 && bytes.substr(8).starts_with(R"({"__metadata__":{)") &&
         bytes.find(std::string("\"kind\":\"") + kKind + '"') != std::string_view::npos;
}
constexpr char kGrid[] = "nlg-light-grid", kKept[] = "nlg-kept-functions";

bool areReports(std::string_view bytes) {
  return bytes.starts_with("{\"scene\":") && bytes.find("\"peak_memory_bytes\":") != std::string_view::npos;
}

bool areInputs(std::string_view bytes) {
  const Json list = Json::parse(bytes, nullptr, false);
  return list.is_array() && std::all_of(list.begin(), list.end(), [](const Json& entry) { return entry.is_string(); }) &&
         std::is_sorted(list.begin(), list.end()) && list.dump() + "\n" == bytes;
}

}  // namespace

const OwnFiles kGridFiles = {"a light grid", areTensorsOf<kGrid>}, kReportFiles = {"what a bake said of itself", areReports},
               kKeptFiles = {"functions that a bake kept", areTensorsOf<kKept>}, kInputsFiles = {"a list of inputs", areInputs};

}  // namespace nlg
