// nlg-view: a level and its light grid → a page in which it is walked through.

#include <CLI/CLI.hpp>
#include <iostream>

#include <nlohmann/json.hpp>

#include "bake/bake_options.h"
#include "bake/policy_options.h"
#include "tool/tool_main.h"
#include "viewer/view_run.h"

int main(int argc, char** argv) {
  using namespace nlg;
  CLI::App app{
      "Makes a page that shows a level lit by its light grid, beside what others use. One walks through it, compares, and looks "
      "at\n"
      "probes and at the places where the grid is most wrong. The page is a folder; a double click opens it, without a network.\n"
      "nlg-view SCENE: bakes the grid first, with the weights that ship.\n"
      "nlg-view SCENE --grid GRID: of a grid that nlg-bake wrote.",
      "nlg-view"};
  ViewRequest request;
  BakeOptions bake;
  OptionTable table("bake");
  describe(bake, table);
  table.addNote(stagesHelp({}));
  table.common({"out", "grid", "weights", "rivals", "unit", "spacing_m", "sky", "sun", "threads"});
  describe(request, app);
  return runTool(argc, argv, app, table, [&] {
    request.rivals_are_given = app.get_option("--rivals")->count() > 0;
    takeThetaPrecision(&bake);
    const nlohmann::ordered_json said = makeView(request, bake);
    std::cerr << "open " << said["page"].get<std::string>() << '\n';
    std::cout << said.dump() << '\n';
  });
}
