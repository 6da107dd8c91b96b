#include "bake/probe_list.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <iostream>
#include <iterator>

#include "bake/again/bake_provenance.h"
#include "tool/command/tool_main.h"

namespace nlg {

std::string probeTable(const LightGrid& grid) {
  const float mean_of_y00 = shBasis(0.0f, 0.0f, 1.0f)[0];
  std::string table = grid.light.empty() ? "x_m,y_m,z_m,kind\n" : "x_m,y_m,z_m,kind,r,g,b\n";
  const auto out = std::back_inserter(table);
  for (size_t p = 0; p < grid.probe_function.size(); ++p) {
    const PositionM at = grid.tree.probePosition(p);
    const uint32_t function = grid.probe_function[p];
    const char* kind = function == kNoWeight ? "none" : function == kFreeSpace ? "tent" : "function";
    fmt::format_to(out, "{:.9g},{:.9g},{:.9g},{}", at[0], at[1], at[2], kind);
    if (!grid.light.empty()) {
      for (int c = 0; c < kShChannels; ++c) fmt::format_to(out, ",{:.4g}", mean_of_y00 * grid.probeLight(p)[c]);
    }
    table += '\n';
  }
  return table;
}

int probeListMain(int argc, char** argv) {
  CLI::App app{
      "Prints the probes of a light grid as CSV: x_m,y_m,z_m, kind (function, tent, or none: no weight), and r,g,b, the mean\n"
      "radiance over all directions.",
      "nlg-bake probes"};
  std::string path;
  OptionTable table("bake");
  app.add_option("grid", path, "light grid (.safetensors)")->required();
  return runTool(argc, argv, app, table, [&] { std::cout << probeTable(readBakedGrid(path).grid); });
}

}  // namespace nlg
