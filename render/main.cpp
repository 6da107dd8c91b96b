// nlg-render: a view of a scene, lit by ground truth, by a light grid, and by what others use → a PNG.

#include <CLI/CLI.hpp>
#include <cstring>
#include <iostream>

#include <nlohmann/json.hpp>

#include "bake/bake_options.h"
#include "bake/policy_options.h"
#include "render/irradiance_table.h"
#include "render/render_run.h"
#include "tool/command/tool_main.h"

namespace nlg {
namespace {

int irradianceMain(int argc, char** argv) {
  CLI::App app{
      "Path traces irradiance at sample points of a scene and writes a table: irradiance by channel, in the unit of the scene's\n"
      "light, and the standard deviation of its noise. For comparisons with another renderer.",
      "nlg-render irradiance"};
  IrradianceRequest request;
  BakeOptions bake;
  OptionTable table("bake");
  describe(bake, table);
  table.common({"rays", "sky", "sun", "unit", "light_unit", "threads"});
  app.add_option("scene", request.scene, "scene, as for nlg-bake")->required();
  app.add_option("--points", request.places,
                 "table of sample points (.csv): the header x,y,z,nx,ny,nz, then one line per point: position in world "
                 "coordinates, metres, and normal")
      ->required();
  app.add_option("--out", request.out,
                 "table to write (.csv): sample points, irradiance r,g,b and its standard deviation dr,dg,db")
      ->required();
  app.add_option("--rays", request.rays, "rays per sample point")->check(CLI::Range(8, 1 << 24))->capture_default_str();
  return runTool(argc, argv, app, table, [&] {
    writeIrradianceTable(request, bake);
    std::cout << request.out << '\n';
  });
}

int renderMain(int argc, char** argv) {
  CLI::App app{
      "Draws a view of a scene, or a horizontal cut, lit by a method: truth (path traced at every pixel), grid (a light grid's\n"
      "look-up at every pixel). Brightness is albedo x irradiance / pi + emission, times the exposure, through\n"
      "Khronos' neutral curve, in sRGB.\n"
      "nlg-render SCENE --out view.png: ground truth, from a chosen view.\n"
      "nlg-render SCENE --grid GRID --panel truth,grid --out view.png: side by side, with the error.\n"
      "nlg-render irradiance SCENE --points POINTS.csv --out FILE.csv: irradiance at sample points, as a table.",
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

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "irradiance") == 0) return nlg::irradianceMain(argc - 1, argv + 1);
  return nlg::renderMain(argc, argv);
}
