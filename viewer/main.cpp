// nlg-view: a level and its light grid → a page in which it is walked through.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include <nlohmann/json.hpp>

#include "bake/bake_options.h"
#include "bake/policy_options.h"
#include "tool/command/tool_main.h"
#include "viewer/view_run.h"
#include "viewer/watch.h"

int main(int argc, char** argv) {
  using namespace nlg;
  CLI::App app{
      "Writes a page to walk through a level that is lit by its light grid and by baselines, with its probes and the sample "
      "points\n"
      "where the grid errs most. The page is a folder; a double click opens it, without a network.\n"
      "nlg-view SCENE: bakes the grid first, with the supplied weights.\n"
      "nlg-view SCENE --grid GRID: shows a grid of nlg-bake.\n"
      "nlg-view SCENE --watch: bakes again whenever the scene is saved, and updates the open page.",
      "nlg-view"};
  ViewRequest request;
  BakeOptions bake;
  bake.spacing_m = 0.0;  // chosen by the scene
  OptionTable table("bake");
  describe(bake, table);
  table.addNote(stagesHelp({}));
  table.common({"out", "grid", "watch", "weights", "baselines", "unit", "spacing_m", "sky", "sun"});
  describe(request, app);
  return runTool(argc, argv, app, table, [&] {
    takeThetaPrecision(&bake);
    if (request.is_watched) {
      // what takes longer than the bake only where it is asked for
      if (app.get_option("--baselines")->count() == 0) request.baselines = {"none"};
      if (app.get_option("--truth-views")->count() == 0) request.truth_views = 0;
      if (app.get_option("--truth-samples")->count() == 0) request.places = 0;
      return watchScene(request, bake, table);
    }
    if (app.get_option("--port")->count() > 0) throw UsageError("--port needs --watch");
    const nlohmann::ordered_json said = makeView(request, bake);
    std::cerr << "open " << said["page"].get<std::string>() << '\n';
    // for programs: people need not read it
    if (::isatty(STDOUT_FILENO) != 1) std::cout << said.dump() << '\n';
  });
}
