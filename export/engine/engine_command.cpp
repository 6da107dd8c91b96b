#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <span>

#include <fmt/format.h>
#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/light_bake.h"
#include "export/engine/quake_light_grid.h"
#include "export/engine/texel_light.h"
#include "export/shader/shader_export.h"
#include "light/air.h"
#include "light/surface_cache.h"
#include "runtime_eval/light_grid/grid_summary.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kChoiceStream = 0x63686f696365, kReportStream = 0x7265706f7274;

struct Request {
  std::string scene, format, out, grid;
  int places = 2000, truth_rays = 1024;
};

// Texels as files, and what an engine that loads them shows.
struct Texels {
  std::string name;
  std::vector<EngineFile> files;
  EngineIrradiance shown;
  Json error = {};  // against path tracing, at the places of the report
};

// What texels hold, in the basis of their format.
struct TexelLight {
  std::vector<LightSh> light;
  std::vector<glm::vec3> directions;  // of a basis that has some
};

// A grid that an engine has.
struct TexelFormat {
  TexelLookUp look_up;           // with every texel valid where the engine leaves some out
  bool is_directed = false;      // ambient and directed light and a direction; otherwise harmonics
  std::string record;            // name of the file that says what was written
  Json place = Json::object();   // where texels lie
  std::optional<Texels> placed;  // plain placement that is there already; none: light of every texel by itself
  std::function<Texels(const std::string& name, const TexelLight& light)> pack;
};

TexelFormat textureFormat(const TextureFormat& texture, const LightBox& box) {
  TexelFormat format{{box, texture.bias}};
  format.record = "light.json";
  format.place = {{"low_m", box.low_m},
                  {"high_m", box.high_m},
                  {"resolution", box.texel_count},
                  {"texture_size", shTextureSize(box.texel_count)}};
  format.pack = [&texture, box](const std::string& name, const TexelLight& light) {
    const LightVolume volume{box, floatsOf(light.light)};
    if (const float largest = largestLight(volume); largest > kMaxEngineLight) {
      throw UsageError("--intensity", "light of at most " + std::to_string(static_cast<int>(kMaxEngineLight)) + " in a texel",
                       fmt::format("{:g}: {:g} times this --intensity makes it fit", largest, intensityThatFits(largest)));
    }
    const std::string texels = packShTexture(volume);
    return Texels{name, {texture.file(box, texels)}, texture.shown(textureOfHalves(texels, shTextureSize(box.texel_count)), box)};
  };
  return format;
}

// The points of a level's grid, and what of its light places in air have.
struct CompiledPlaces {
  std::vector<glm::dvec3> places;
  std::vector<LightSh> light;
  std::vector<uint8_t> is_read;  // by point: whether some place reads it
};

CompiledPlaces compiledPlaces(const CompiledLight& compiled, const std::vector<glm::dvec3>& places, const glm::dvec3& origin_m,
                              int thread_count) {
  std::vector<ProbeWeights> seen(places.size());
  parallelFor(places.size(), thread_count, [&](uint64_t i, int) { compiled.weightsAt(places[i], &seen[i]); });
  CompiledPlaces result;
  TexelLookUp whole = compiled.grid().lookUp();
  result.is_read.resize(whole.box.texelCount());
  whole.is_valid.assign(whole.box.texelCount(), 1);
  constexpr float kUp[3] = {0.0f, 1.0f, 0.0f};
  for (size_t p = 0; p < places.size(); ++p) {
    const glm::dvec3 world = places[p] + origin_m;
    ProbeWeights read;
    whole.weightsAt({world.x, world.y, world.z}, kUp, &read);
    for (int i = 0; i < read.count; ++i) result.is_read[read.probe[i]] = 1;
    if (seen[p].count == 0) continue;
    result.places.push_back(places[p]);
    result.light.push_back(compiled.grid().light(seen[p]));
  }
  return result;
}

// Points that no place reads stay as they are. All others hold light, also in solid: they serve the air around them.
TexelFormat quakeFormat(const QuakeLevel& level, const CompiledPlaces& compiled) {
  TexelFormat format{{level.box, 0.0, std::vector<uint8_t>(level.box.texelCount(), 1)}, true};
  const std::string maps = "maps/" + level.name;
  format.record = maps + "/light.json";
  format.placed = {"the level's own", {{maps + ".bsp", level.bytes}}, quakeIrradiance(level, {{}, lightGridOf(level)})};
  format.pack = [&level, maps, is_read = compiled.is_read](const std::string& name, const TexelLight& light) {
    const QuakeGridBytes bytes = quakeGridBytes(level, light.light, light.directions, is_read);
    return Texels{name,
                  {{maps + "/lightgrid.raw", bytes.raw}, {maps + ".bsp", withLightGrid(level, bytes.lump)}},
                  quakeIrradiance(level, bytes)};
  };
  return format;
}

// Every way to fill the texels of a format; the first is plain placement.
class TexelWays {
 public:
  TexelWays(const MeasuredScene& scene, const TexelFormat& format) : scene_(scene), format_(format) {}

  std::vector<Texels> all() const {
    std::vector<LightSh> placement;
    std::vector<Texels> ways;
    std::vector<PositionM> places_m;
    for (const glm::dvec3& place : scene_.places) places_m.push_back(inWorld(scene_.transport.scene(), place));
    if (format_.placed) {
      ways.push_back(*format_.placed);
    } else {
      placement = lightOf(placeTexels(scene_, format_.look_up.box));
      ways.push_back(format_.pack("placed", {placement, {}}));
    }
    // as a bake weighs errors, in shares of the light where they stand; and more as they are, which squares of errors ask for
    ProbeLightOptions evenly = scene_.options;
    evenly.dark_share = 1.0, evenly.outlier = 3.0;
    for (const auto& [word, options] : {std::pair("solved", scene_.options), std::pair("solved evenly", evenly)}) {
      const std::string name = word;
      const auto add = [&](const std::string& way, const TexelLight& solution) {
        ways.push_back(format_.pack(way, solution));
        if (!placement.empty()) ways.push_back(format_.pack("half " + way, halfWay(placement, solution)));
      };
      TexelLight solution = solved(options, format_.look_up);
      add(name, solution);
      if (format_.look_up.bias == 0.0) continue;
      solution.light = solveByNormal(format_.look_up, places_m, scene_.place_light, solution.light, options, scene_.thread_count);
      add(name + " by normal", solution);
    }
    return ways;
  }

 private:
  static std::vector<glm::vec3> directionsOf(const std::vector<LightSh>& light) {
    std::vector<glm::vec3> directions(light.size());
    std::transform(light.begin(), light.end(), directions.begin(), mainDirection);
    return directions;
  }

  // Errors of placement and of a solve are others: between the two both are less.
  static TexelLight halfWay(const std::vector<LightSh>& placement, TexelLight solution) {
    for (size_t t = 0; t < placement.size(); ++t) {
      for (int k = 0; k < kShCount; ++k) solution.light[t][k] = 0.5f * (solution.light[t][k] + placement[t][k]);
    }
    return solution;
  }

  TexelLight solved(const ProbeLightOptions& options, const TexelLookUp& look_up) const {
    const MeasuredScene scene{scene_.transport, scene_.places, scene_.place_light, options, scene_.thread_count};
    TexelLight texels{solveTexels(scene, look_up, scene.place_light), {}};
    if (!format_.is_directed) return texels;
    // directions first: once they are known, the rest is linear
    texels.directions = directionsOf(texels.light);
    std::vector<LightSh> place_light(scene.place_light.size());
    for (size_t i = 0; i < place_light.size(); ++i)
      place_light[i] = meanAndDirected(scene.place_light[i], blended(scene.places[i], look_up, texels.directions));
    texels.light = solveTexels(scene, look_up, place_light);
    return texels;
  }

  glm::vec3 blended(const glm::dvec3& place_m, const TexelLookUp& look_up, const std::vector<glm::vec3>& directions) const {
    constexpr float kUp[3] = {0.0f, 1.0f, 0.0f};
    ProbeWeights weights;
    look_up.weightsAt(inWorld(scene_.transport.scene(), place_m), kUp, &weights);
    glm::vec3 sum(0.0f);
    for (int i = 0; i < weights.count; ++i) sum += weights.weight[i] * directions[weights.probe[i]];
    return unitOr(sum, {kUp[0], kUp[1], kUp[2]});
  }

  const MeasuredScene& scene_;
  const TexelFormat& format_;
};

constexpr GroupFigures LightFigures::*kGroups[] = {&LightFigures::air, &LightFigures::surface, &LightFigures::turned};
constexpr const char* kGroupNames[] = {"air", "surface", "turned"};

// How a way does beside placement, where it does worst.
double worstShare(const LightFigures& way, const LightFigures& placed) {
  double worst = 0.0;
  for (const auto group : kGroups) worst = std::max(worst, (way.*group).rmse / (placed.*group).rmse);
  return worst;
}

// The way to ship: the one with the least error beside that of placement, which is shipped where none has less.
size_t bestOf(const std::vector<Texels>& ways, const TexelJudge& choice) {
  const LightFigures placed = choice.errorOf(ways.front().shown);
  size_t best = 0;
  double least = 1.0;
  for (size_t w = 1; w < ways.size(); ++w) {
    const double share = worstShare(choice.errorOf(ways[w].shown), placed);
    if (share < least) least = share, best = w;
  }
  return best;
}

Json errorJson(const LightFigures& figures) {
  Json json;
  for (size_t g = 0; g < std::size(kGroups); ++g) json[kGroupNames[g]] = (figures.*kGroups[g]).rmse;
  return json;
}

// extent_m as it is; without one, where the scene would have probes, and a texel on every side: there filters find light.
LightBox boxOf(const PreparedScene& scene, const BakeOptions& options) {
  if (const auto extent = extentFromNumbers(options.extent_m)) {
    const glm::dvec3 low = extent->low_m, high = extent->high_m;
    return texelBox({low.x, low.y, low.z}, {high.x, high.y, high.z}, scene.spacing_m);
  }
  GridBounds bounds = boundsOf(scene.treeInWorld());
  for (size_t axis = 0; axis < 3; ++axis) bounds.low_m[axis] -= scene.spacing_m, bounds.high_m[axis] += scene.spacing_m;
  return texelBox(bounds.low_m, bounds.high_m, scene.spacing_m);
}

// Mean radiance of what arrives at sample points, for an exposure.
std::array<float, kShChannels> meanRadiance(const std::vector<LightSh>& place_light) {
  glm::vec3 sum(0.0f);
  for (const LightSh& light : place_light) sum += light[0];
  // the first basis function is a constant
  sum *= shBasis(0, 0, 0)[0] / static_cast<float>(std::max<size_t>(1, place_light.size()));
  return {sum.x, sum.y, sum.z};
}

// Writes bytes of a file beside its path; then all files before it take their names, then it does.
void writeInOrder(const std::string& folder, std::span<const EngineFile> files) {
  if (files.empty()) return;
  const EngineFile& last = files.back();
  writeAtomically((std::filesystem::path(folder) / last.name).string(), [&](const std::string& temporary_path) {
    writeFileAtomically(temporary_path, last.bytes);
    writeInOrder(folder, files.first(files.size() - 1));
  });
}

// Texels alone bear no name: where the record is that this tool wrote beside them, they are replaced, and nothing else is. So the
// record comes first, or a run that was killed before it could not be run again; and it comes when all texels are on the disk.
// inputs   files that must not be among those to come
void writeFolder(const std::string& folder, const EngineFile& record, std::vector<EngineFile> files,
                 const std::vector<std::string>& inputs) {
  namespace fs = std::filesystem;
  const auto pathOf = [&](const EngineFile& file) { return (fs::path(folder) / file.name).string(); };
  const bool is_own = fs::exists(pathOf(record)) && mayReplace(pathOf(record), kExportedFiles);
  files.insert(files.begin(), record);
  for (const EngineFile& file : files) {
    refuseToReplaceInputs(pathOf(file), inputs);
    if (!is_own) refuseToReplaceOthers(pathOf(file), kExportedFiles);
  }
  writeInOrder(folder, files);
}

void run(const Request& request, const BakeOptions& options, const OptionTable& table) {
  const TextureFormat* texture = findTexture(request.format);
  if (texture == nullptr && request.format != kQuakeFormat)
    throw UsageError("--format", textureNames() + kQuakeFormat, "'" + request.format + "'");
  // how a grid's probes are lit; a scene that is read for "none" would have no colours of images
  if (options.light != "solved") throw UsageError("light", "solved: texels have no other", "'" + options.light + "'");
  const std::optional<BakedGrid> baked = request.grid.empty() ? std::nullopt : std::optional(readLitGrid(request.grid));
  const QuakeLevel level = texture == nullptr ? readQuakeLevel(request.scene) : QuakeLevel{};
  const PreparedScene scene(request.scene, options);
  tellNotes("nlg-export", scene.source);
  // an error against the truth of another scene is not wrong, but seldom what was meant
  if (const std::string other = baked ? otherSceneOrLight(baked->metadata, scene.source) : ""; !other.empty())
    std::cerr << "nlg-export: " << request.grid << ": " << other << '\n';
  if (!scene.source.scene.light.groups.names.empty())
    std::cerr << "nlg-export: a texel holds the sum of all light: groups of light and light states are not kept apart\n";
  const int threads = threadsOf(options);
  const LightTransport transport(scene.source.scene, scene.rays);
  const glm::dvec3& origin_m = scene.source.scene.origin_m;
  std::optional<CompiledLight> compiled;
  ProbeLightOptions light = probeLightOptions(options, scene.air.places.size());
  std::unique_ptr<SurfaceCache> cache;
  CompiledPlaces at;
  if (texture == nullptr) {
    compiled.emplace(level, scene.rays, origin_m);
    at = compiledPlaces(*compiled, scene.air.places, origin_m, threads);
  } else {
    // as a bake measures it
    at.places = scene.air.places;
    cache = makeSurfaceCache(transport, at.places, scene.air.spacing_m, light, threads);
    light.place.cache = light.probe.cache = cache.get();
    at.light = measureLight(transport, at.places, light.place, light.seed, threads);
  }
  const TexelFormat format = texture == nullptr ? quakeFormat(level, at) : textureFormat(*texture, boxOf(scene, options));
  const MeasuredScene measured{transport, at.places, at.light, light, threads};

  // chosen at some places, reported at others
  std::vector<Texels> ways = TexelWays(measured, format).all();
  const ExtentBox extent = lightExtent(scene.source.scene, options.extent_m);
  const auto judgeOf = [&](uint64_t stream) {
    TexelJudge judge(measured, extent, request.places, mixSeed(options.seed, stream));
    if (!compiled) {
      judge.trace(request.truth_rays);
      return judge;
    }
    judge.take([&](const glm::dvec3& position_m, const float* normal_3, glm::vec3* irradiance) {
      ProbeWeights seen;
      compiled->weightsAt(position_m, &seen);
      *irradiance = glm::make_vec3(compiled->grid().shown(seen, normal_3).data());
      return seen.count > 0;
    });
    return judge;
  };
  const size_t best = bestOf(ways, judgeOf(kChoiceStream));
  const std::string shipped = ways[best].name;
  const std::vector<EngineFile> files = ways[best].files;
  if (baked) {
    ways.push_back({"the light grid", {}, [&baked](const PositionM& position_m, const float* normal_3) {
                      std::array<float, kShChannels> rgb;
                      lookUpIrradiance(baked->grid, position_m, normal_3, rgb.data());
                      return rgb;
                    }});
  }
  const TexelJudge report = judgeOf(kReportStream);
  for (Texels& way : ways) way.error = errorJson(report.errorOf(way.shown));

  Json line = {{"scene", scene.source.id}, {"format", request.format}, {"shipped", shipped}};
  line.update(format.place);
  line["mean_radiance"] = meanRadiance(at.light);
  line["places"] = report.placeCount();
  if (!compiled) line["noise"] = report.noise();
  for (const Texels& way : ways) line["error"][way.name] = way.error;
  Json record = line;
  record["provenance"] = provenance("nlg-export engine", table.toJson(), {{"scene", scene.source.sha256}});
  writeFolder(request.out, {format.record, record.dump(2) + "\n"}, files, {request.scene, request.grid});
  std::cout << line.dump() << '\n';
  if (best == 0)
    std::cerr << "nlg-export: no solve errs less than "
              << (compiled ? "the level's own light grid: it is" : "texels with the light of their own place: these are")
              << " written\n";
}

}  // namespace

int engineMain(int argc, char** argv) {
  CLI::App app{
      "Lights the grid that an engine has, for the look-up that it has, and measures the error against path tracing, of\n"
      "quake3-lightgrid against the level's own light.\n"
      "Settings of the bake: section bake of the configuration. spacing_m is the largest width of a texel, extent_m the box.",
      "nlg-export engine"};
  Request request;
  BakeOptions options;
  options.spacing_m = 0.0;  // chosen by the scene, as nlg-bake does
  OptionTable table("bake");
  describe(options, table);
  table.common({"format", "out", "grid", "spacing_m", "extent_m", "sky", "sun", "intensity", "threads"});
  app.add_option("scene", request.scene, "scene, as for nlg-bake")->required();
  app.add_option("--format", request.format, textureNames() + kQuakeFormat)->required();
  app.add_option("--out", request.out,
                 "folder for the format's files; of quake3-lightgrid the game's, such as ~/.openarena/baseoa")
      ->required();
  app.add_option("--grid", request.grid, "light grid of this scene, whose own look-up is measured, too");
  app.add_option("--places", request.places, "sample points in air, and as many before surfaces, at which errors are measured")
      ->check(CLI::Range(100, 1000000))
      ->capture_default_str();
  app.add_option("--truth-rays", request.truth_rays,
                 "rays of ground truth per sample point; quake3-lightgrid traces none: its truth is the level's own light")
      ->check(CLI::Range(8, 1 << 24))
      ->capture_default_str();
  return runTool(argc, argv, app, table, [&] { run(request, options, table); });
}

}  // namespace nlg
