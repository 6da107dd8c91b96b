// One run of nlg-view: writes a folder with a page to walk through a level that is lit by its light grid.
//
//     index.html, viewer.js     the page; it opens by a double click, or from any server of files
//     scene.js                  triangles, materials, views, worst places, methods and what they cost
//     method-NAME.js            what the page's shaders read of a method; probes.js, truth-N.js likewise: read when they are asked for
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake/bake_options.h"

namespace CLI {
class App;
}

namespace nlg {

struct ViewRequest {
  std::string scene, grid;
  std::string out;                   // empty: by the name of the scene
  std::vector<std::string> weights;  // without a grid: to bake one
  std::vector<std::string> baselines = {"valid-trilinear", "ddgi"};
  int truth_views = 3;      // 0: none
  int truth_width = 640;    // pixels of such a view; its height is 9/16 of it
  int truth_rays = 64;      // of a pixel
  int places = 800;         // where methods are compared with truth; 0: nowhere
  bool is_watched = false;  // watch.h
  int port = 8370;          // of a watch; 0: any that is free
};

// Where a page of this scene lies unless told otherwise: "house" of levels/house.glb.
std::string folderOfView(const std::string& scene);

// throws   UsageError where a file in the folder that the page is to be written to is of that name and no view wrote it
void refuseToReplaceOthersOf(const ViewRequest& request);

// Adds all settings to the command line.
void describe(ViewRequest& request, CLI::App& app);

// Writes the folder, and says what is in it.
// throws   UsageError, InputError, OutputError
nlohmann::ordered_json makeView(ViewRequest request, BakeOptions options);

}  // namespace nlg
