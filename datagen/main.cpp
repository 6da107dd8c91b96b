// nlg-datagen: scenes → shards of weighting functions, and what there is to know about both.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "datagen/commands.h"
#include "datagen/dataset/shard_file.h"
#include "scene/archive/scene_file.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/output_path.h"
#include "tool/printable.h"

namespace nlg {
namespace {

const std::vector<std::string> kCommonOptions = {"jitter",        "held_out", "unit",          "spacing_min_m",
                                                 "spacing_max_m", "threads",  "max_functions", "json"};

// What generating and planning ask for alike.
void addRequest(CLI::App& app, ShardRequest& request) {
  app.add_option("--scene", request.scene, sceneForms())->required();
  app.add_option("--jitter", request.jitter, "number of the jittered variant. 0: the scene as it is")
      ->check(CLI::Range(0.0, 0x1p53));
  app.add_flag("--held-out", request.held_out, "mark the scene as held-out, and store test points that no fit sees");
}

int generateMain(int argc, char** argv) {
  CLI::App app{
      "Computes the weighting functions of one scene under one jitter and writes them as one shard.\n"
      "nlg-datagen plan --scene SCENE: estimates time, memory and size of a shard.\n"
      "nlg-datagen info FILE ...: verifies and describes shards.\n"
      "nlg-datagen info FOLDER: describes a data set.\n"
      "nlg-datagen info SCENE ...: describes scenes, and what was not read.\n"
      "nlg-datagen geometry SHARD: prints the shard's scene, for pictures.",
      "nlg-datagen"};
  ShardRequest request;
  std::string out;
  DatagenOptions options;
  OptionTable table("datagen");
  describe(options, table);
  table.common(kCommonOptions);
  addRequest(app, request);
  app.add_option("--out", out, "shard to write (.h5)")->required();
  return runTool(argc, argv, app, table, [&] {
    // what the scene's file names is among what others wrote
    refuseToReplace(out, {request.scene}, kShardFiles);
    generate(request, out, options, table);
  });
}

int planMain(int argc, char** argv) {
  CLI::App app{"Estimates the time, memory and size of a shard from a sample of its probes. Writes nothing.", "nlg-datagen plan"};
  ShardRequest request;
  DatagenOptions options;
  bool json = false;
  int sample = 1000;
  OptionTable table("datagen");
  describe(options, table);
  table.common(kCommonOptions);
  addRequest(app, request);
  app.add_flag("--json", json, "print one line of JSON");
  app.add_option("--sample", sample, "number of functions computed for the estimate, duplicates included")
      ->check(CLI::Range(16, 1000000))
      ->capture_default_str();
  return runTool(argc, argv, app, table, [&] {
    printPlan(request, planShard(request, options, table, sample), json ? PlanFormat::json : PlanFormat::text);
  });
}

int sceneInfoMain(int argc, char** argv) {
  CLI::App app{"Prints what scenes hold: triangles, size, materials, images, solids, lights, and what was not read.",
               "nlg-datagen info"};
  std::vector<std::string> scenes;
  SceneReading reading;
  bool json = false, digest = false;
  OptionTable table("datagen");
  describe(reading, table);
  table.common({"unit", "transmissive_cover", "cavity_m"});
  app.add_option("scenes", scenes, sceneForms())->required();
  app.add_flag("--json", json, "print one line of JSON per scene");
  app.add_flag("--digest", digest, "print only the SHA-256 of each scene's geometry, which copies have in common");
  return runTool(argc, argv, app, table, [&] {
    for (const std::string& scene : scenes) {
      if (digest) {
        std::cout << sceneDigest(scene, reading) << "  " << printable(scene) << '\n';
        continue;
      }
      const nlohmann::ordered_json found = describeScene(scene, reading);
      std::cout << (json ? found.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n'
                         : sceneText(found));
    }
  });
}

int dataCardMain(int argc, char** argv) {
  CLI::App app{
      "Prints what a folder of shards holds: probes and functions of every scene, what was left out and why, and how hard the "
      "functions are.",
      "nlg-datagen info"};
  std::string folder;
  std::vector<std::string> shards;
  bool json = false;
  OptionTable table("datagen");
  app.add_option("folder", folder, "folder of shards (.h5), or of folders of shards")->required();
  app.add_option("--shards", shards, "shards to describe. None: all in the folder or below");
  app.add_flag("--json", json, "print one line of JSON");
  return runTool(argc, argv, app, table, [&] {
    const nlohmann::ordered_json card = dataCard(folder, shards);
    std::cout << (json ? card.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n' : dataCardText(card));
  });
}

int infoMain(int argc, char** argv) {
  // of scenes or a folder, where the first argument is one; a folder in the place of a shard is a shard that cannot be read
  const auto is_name = [](const char* argument) { return argument[0] != '-'; };
  char** const first = std::find_if(argv + 1, argv + argc, is_name);
  std::error_code error;
  if (first != argv + argc && !std::string(*first).ends_with(".h5") && std::filesystem::is_directory(*first, error))
    return dataCardMain(argc, argv);
  if (first != argv + argc && !isShardRequest(*first)) return sceneInfoMain(argc, argv);
  return fileInfoMain(argc, argv, {"nlg-datagen info", "shards (.h5)", "datagen", describeShard});
}

int geometryMain(int argc, char** argv) {
  CLI::App app{"Prints the triangles of a shard's scene as one line of JSON; null for a level whose file is not named.",
               "nlg-datagen geometry"};
  std::string shard, scene;
  bool with_tree = false;
  OptionTable table("datagen");
  table.addNote(sceneBudgets());
  app.add_option("shard", shard, "shard (.h5)")->required();
  app.add_option("--scene", scene, "file of the level. Procedural scenes need none");
  app.add_flag("--tree", with_tree, "print the nodes and cells of the probe tree as well");
  return runTool(argc, argv, app, table, [&] { std::cout << shardGeometry(shard, scene, with_tree) << '\n'; });
}

// without one it generates a shard
constexpr Command kCommands[] = {{"info", infoMain}, {"plan", planMain}, {"geometry", geometryMain}};

}  // namespace
}  // namespace nlg

int main(int argc, char** argv) {
  if (const std::optional<int> status = nlg::runCommand(argc, argv, nlg::kCommands)) return *status;
  return nlg::generateMain(argc, argv);
}
