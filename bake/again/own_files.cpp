#include "bake/again/own_files.h"

namespace nlg {
namespace {

bool areGrids(std::string_view bytes) {
  return bytes.size() > 8 && bytes.substr(8).starts_with(R"({"__metadata__":{)") && hold(bytes, R"("kind":"nlg-light-grid")");
}

bool areReports(std::string_view bytes) { return bytes.starts_with("{\"scene\":") && hold(bytes, "\"peak_memory_bytes\":"); }

}  // namespace

const OwnFiles kGridFiles = {"a light grid", areGrids}, kReportFiles = {"what a bake said of itself", areReports};

}  // namespace nlg
