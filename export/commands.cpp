#include "export/commands.h"

#include <nlohmann/json.hpp>

#include "export/engine/texel_light.h"
#include "export/shader/shader_export.h"
#include "nlg/generator.h"
#include "runtime_eval/evaluator/generator/generator_data.h"
#include "tool/command/file_info.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

nlohmann::ordered_json describeWeights(const std::string& path) {
  WeightsFile file;
  GeneratorData data;
  requireRead(path, readWeightsFile(path, &file), "the weights of a generator (nlg-bake info describes light grids)");
  requireRead(path, generatorFromWeights(file, &data), "the weights of a generator");
  nlohmann::ordered_json json = {{"representation", representationName(data.representation)},
                                 {"theta", data.representation.thetaCount()},
                                 {"coefficients", data.basis.coefficientCount()},
                                 {"layers", data.layers.size()},
                                 {"width", data.layers.front().output_count}};
  // weights of before there was a blend RMSE hold an RMSE
  for (const char* key :
       {"version", "basis_functions", "training_set_sha256", "held_out_blend_rmse_mean", "held_out_rmse_mean", "parity_theta"}) {
    if (const auto found = file.metadata.find(key); found != file.metadata.end()) json[key] = found->second;
  }
  json["verified"] = kVerifiedByDigest;
  json["origin"] = parsedOrText(file.metadata["provenance"]);
  return json;
}

int infoMain(int argc, char** argv) {
  return fileInfoMain(argc, argv, {"nlg-export info", "weights (.safetensors)", "export", describeWeights});
}

constexpr Command kEachCommand[] = {{"info", infoMain}, {"shader", shaderMain}, {"engine", engineMain}};

}  // namespace

const char* const kCommands =
    "nlg-export info FILE ...: verifies and describes weights.\n"
    "nlg-export shader --grid GRID --out FOLDER: writes a light grid with its look-up in GLSL, for three.js or in C.\n"
    "nlg-export engine SCENE --format FORMAT --out FOLDER: lights the grid that an engine has, for its own look-up.";

std::optional<int> runCommand(int argc, char** argv) { return runCommand(argc, argv, kEachCommand); }

}  // namespace nlg
