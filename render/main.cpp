// nlg-render: a view of a scene, lit by ground truth, by a light grid, and by what others use → a PNG.

#include <CLI/CLI.hpp>
#include <iostream>

#include <nlohmann/json.hpp>

#include "bake/bake_options.h"
#include "bake/policy_options.h"
#include "render/render_run.h"
#include "tool/tool_main.h"

int main(int argc, char** argv) {
  using namespace nlg;
  CLI::App app{
      "Draws a view of a scene, or a horizontal cut, lit by a method: truth (path traced at every pixel), grid (a light grid's\n"
      "look-up at every pixel). Brightness is albedo x irradiance / pi + emission, times the exposure, cut off at 1, in sRGB.\n"
      "nlg-render SCENE --out view.png: ground truth, from a view that shows something.\n"
      "nlg-render SCENE --grid GRID --panel truth,grid --out view.png: side by side, with the error.",
      "nlg-render"};
  RenderRequest request;
  BakeOptions bake;
  OptionTable table("bake");
  describe(bake, table);
  table.addNote(stagesHelp({}));
  table.common({"grid", "bake", "method", "panel", "truth_rays", "exposure", "camera", "width"});
  describe(request, app);
  return runTool(argc, argv, app, table, [&] {
    takeThetaPrecision(&bake);
    std::cout << renderScene(request, bake).dump() << '\n';
  });
}
