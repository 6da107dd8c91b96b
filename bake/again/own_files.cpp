#include "bake/again/own_files.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace nlg {
namespace {

using Json = nlohmann::json;

constexpr char kBytes = 1;

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

std::string inputsText(const std::vector<std::string>& paths) {
  Json names = Json::array();
  for (const std::string& path : paths) {
    const bool is_text = path[0] != kBytes && Json::parse(Json(path).dump(-1, ' ', false, Json::error_handler_t::ignore)) == path;
    std::string bytes(1, kBytes);
    for (const unsigned char byte : path) {
      if (byte >= 0x80) bytes += static_cast<char>(0xc0 | byte >> 6);
      bytes += static_cast<char>(byte < 0x80 ? byte : 0x80 | (byte & 0x3f));
    }
    names.push_back(is_text ? path : bytes);
  }
  std::sort(names.begin(), names.end());
  return names.dump() + "\n";
}

std::vector<std::string> inputsOf(const std::string& text) {
  auto paths = Json::parse(text).get<std::vector<std::string>>();
  for (std::string& path : paths) {
    if (path[0] != kBytes) continue;
    std::string bytes;
    for (size_t at = 1; at < path.size(); ++at) {
      const auto byte = static_cast<unsigned char>(path[at]);
      bytes += byte < 0x80 ? path[at] : static_cast<char>((byte & 3) << 6 | (path[++at] & 0x3f));
    }
    path = bytes;
  }
  return paths;
}

}  // namespace nlg
