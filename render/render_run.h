// One run of nlg-render: its request and its result.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake/bake_options.h"

namespace CLI {
class App;
}

namespace nlg {

struct RenderRequest {
  std::string program = "nlg-render";  // whose messages these are
  std::string panel_flag = "--panel";
  std::string scene, out;
  // what is lit by what
  std::string grid;                  // a light grid's file
  bool bake = false;                 // in place of a file: baked here, by the options of a bake
  std::vector<std::string> weights;  // for that
  std::string method = "truth";
  std::vector<std::string> panel;  // several methods side by side; empty: method alone
  std::string show = "light";      // light, error, absolute
  int truth_rays = 64;             // of every sample
  double exposure = 0.0;           // 0: automatic
  double error_range = 0.0;        // 0: automatic
  // from where
  std::string camera;             // name or number of one that the scene's file holds
  std::vector<double> eye, look;  // world, metres
  double fov = 0.0;               // degrees, from the lower to the upper edge; 0: the camera's own, or 60
  std::vector<double> slice_y;    // world, metres: a cut at this height in place of a view
  int width = 640, height = 360, samples = 2;
  double offset_m = 0.02;
};

// The methods that are asked for: those of the panel, or the one.
std::vector<std::string> methodNames(const RenderRequest& request);
bool asksFor(const RenderRequest& request, const std::string& method);

// Adds all settings to the command line.
void describe(RenderRequest& request, CLI::App& app);

// Draws, writes request.out, and says what was drawn: camera in world coordinates, exposure, errors.
// threads, seed, and everything of a bake come from `options`
// throws   UsageError, InputError, OutputError
nlohmann::ordered_json renderScene(const RenderRequest& request, const BakeOptions& options);

}  // namespace nlg
