#include "validate/commands.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/again/bake_provenance.h"
#include "bake/scene_bake.h"
#include "light/air.h"
#include "light/methods/method_set.h"
#include "render/picture/image.h"
#include "render/rendered_scene.h"
#include "render/tone.h"
#include "runtime_eval/numbers/random.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "validate/generators/summary_json.h"
#include "validate/light/asked_bakes.h"
#include "validate/views/view_truth.h"
#include "validate/views/views_json.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

// Of views and truth, whatever the seed of the bake: another shift of the lattice is judged on the same pictures.
constexpr uint64_t kSeed = 1, kViewStream = 0x7669657773, kTruthStream = 0x7472757468;

// On figures.
const std::vector<std::string> kWithoutEffect = {"threads", "representation", "picture_scale"};

struct Request {
  std::string scene, out;
  std::vector<std::string> weights, grids;
  bool cameras = false;  // the scene's own in place of views that are found
  SceneViewOptions views;
  int truth_rays = 128, probe_rays = 512;
  double truth_noise = 0.1;
  bool grids_only = false, target_functions = false;
  std::string truth;     // the folder for truths; empty: beside the result
  std::string pictures;  // the folder for pictures; empty: none are drawn
  int picture_scale = 4;
};

// A view and what is known of it before any method is asked.
struct ReadyView {
  ViewSurfaces surfaces;
  ViewTruth truth;
  int truth_rays = 0;  // of every pixel
};

class ViewsMeasurement {
 public:
  ViewsMeasurement(const Request& request, const BakeOptions& options, const PreparedScene& scene)
      : request_(request),
        options_(options),
        scene_(scene),
        threads_(options.threads > 0 ? options.threads : machineThreadCount()),
        transport_(scene.source.scene, scene.rays),
        views_(request.cameras ? cameraViews(transport_)
                               : findViews(transport_, lightExtent(scene.source.scene, options.extent_m), request.views)) {
    if (views_.views.empty() && request.cameras) throw InputError(request.scene, "cameras", "one or more", "none");
    if (views_.views.empty()) throw InputError(request.scene, "air", "points where a player can stand", "none");
    ViewTruthOptions truth;
    truth.gather.rays = request.truth_rays;
    truth.noise = request.truth_noise;
    truth.gather.direct = directLightFromName(options.light_direct);
    truth.seed = mixSeed(kSeed, kTruthStream);
    truth.thread_count = threads_;
    truth.scene_sha256 = sceneLightSha256(scene.source.scene);
    Progress progress("views", static_cast<int64_t>(views_.views.size()));
    std::vector<TracedView> traced;
    double brightest = leastAdapted(scene.source.scene) / kLeastLight;  // at least
    for (size_t v = 0; v < views_.views.size(); ++v) {
      ReadyView& ready = ready_.emplace_back();
      ready.surfaces = surfacesOf(transport_, views_.views[v], request.views.width, request.views.height, threads_);
      const std::string path = (std::filesystem::path(request.truth) / (viewName(v) + ".truth.safetensors")).string();
      traced.push_back(viewTruth(transport_, ready.surfaces.sights, truth, path));
      ready.truth_rays = traced.back().rounds * request.truth_rays;
      brightest = std::max(brightest, medianLight(ready.surfaces.sights, traced.back().at));
      progress.update(static_cast<int64_t>(v) + 1);
    }
    for (size_t v = 0; v < ready_.size(); ++v) {
      ready_[v].truth = truthOf(ready_[v].surfaces, std::move(traced[v].at), brightest, threads_);
      counted_views_ += ready_[v].truth.isCounted();
    }
    if (std::none_of(ready_.begin(), ready_.end(), [](const ReadyView& view) { return view.truth.isLit(); }))
      throw InputError(request.scene, "light", "light in a view or more", fmt::format("none in {}", ready_.size()));
    if (counted_views_ == 0)
      throw InputError(request.scene, "truth", fmt::format("a view whose noise is at most {:.2f}", kMostNoise),
                       fmt::format("none of {}; raise --truth-rays", ready_.size()));
  }

  Json measure(const GeneratorSets& sets) {
    MethodSet methods({transport_, scene_.tree, scene_.air},
                      methodSetOptions(options_, {request_.probe_rays, 64}, scene_.air.places.size(), threads_));
    if (request_.target_functions) methods.addTargetFunctions(receivers(), options_.diffusion, {LightWay::solved});
    methods.addExactVisibility({LightWay::solved});
    for (const auto& [name, generators] : sets) measureGrid(name, generators);
    for (const std::string& path : request_.grids) {
      const BakedGrid baked = readLitGrid(path);
      if (const std::string other = otherSceneOrLight(baked.metadata, scene_.source); !other.empty())
        std::cerr << "nlg-validate: " << path << ": " << other << '\n';
      measure(std::filesystem::path(path).stem().string(), "of its file", gridLight(baked.grid, scene_.source.scene.origin_m));
    }
    grid_count_ = measured_.size();
    for (const MethodSet::Baseline& baseline : MethodSet::baselines()) {
      if (baseline.is_technique && !request_.grids_only) (methods.*baseline.add)({LightWay::point});
    }
    for (const LightMethod& method : methods.methods()) measure(method.weights, method.light, method.light_at);
    return results();
  }

  std::string table() const {
    std::string text = viewsTable(scene_.source.id, ofCounted(), meanOf(&ViewTruth::colour_noise));
    if (counted_views_ < ready_.size())
      text += fmt::format("{} of {} views are not counted: light does not reach them, or their truth is too noisy\n",
                          ready_.size() - counted_views_, ready_.size());
    if (views_.rooms_dark > 0)
      text +=
          fmt::format("{} of {} rooms are dark: they come last\n", views_.rooms_dark, views_.rooms - views_.rooms_without_floor);
    if (!request_.grids_only && !hasSheets(transport_.scene())) text += "no double-sided faces: DDGI has one rule for backs\n";
    return text;
  }

 private:
  double meanOf(double ViewTruth::*noise) const {
    double sum = 0.0;
    for (const ReadyView& view : ready_) sum += view.truth.isCounted() ? view.truth.*noise : 0.0;
    return sum / static_cast<double>(counted_views_);
  }

  // Of views that means are made of.
  std::vector<MeasuredViews> ofCounted() const {
    std::vector<MeasuredViews> methods;
    for (const MeasuredViews& method : measured_) {
      MeasuredViews& known = methods.emplace_back(MeasuredViews{method.weights, method.light, {}});
      for (size_t v = 0; v < ready_.size(); ++v) {
        if (ready_[v].truth.isCounted()) known.views.push_back(method.views[v]);
      }
    }
    return methods;
  }

  std::string viewName(size_t view) const { return fmt::format("{}_{:02}", fileWord(scene_.source.id), view + 1); }

  // As the bake leaves it in its file.
  void measureGrid(const std::string& name, const std::vector<Generator>& generators) {
    const LightGrid grid = bakeScene(scene_, generators, options_, temporaryFolder()).grid;
    measure(name, options_.light, gridLight(grid, scene_.source.scene.origin_m));
  }

  void measure(const std::string& weights, const std::string& light, const LightAt& light_at) {
    MeasuredViews& measured = measured_.emplace_back(MeasuredViews{weights, light, {}});
    for (size_t v = 0; v < ready_.size(); ++v) {
      const std::vector<LightAnswer> answers = lightSamples(ready_[v].surfaces.sights, light_at, threads_);
      measured.views.push_back(viewFigures(ready_[v].surfaces, ready_[v].truth, answers));
      if (!request_.pictures.empty())
        pictures_[v].push_back({pictureOf(ready_[v].surfaces.sights, weights, answers), measured.views.back()[0]});
    }
  }

  std::vector<glm::dvec3> receivers() const {
    std::vector<glm::dvec3> places;
    for (const ReadyView& view : ready_) {
      for (const Sight& sight : view.surfaces.sights.samples) {
        if (sight.kind == Sight::Kind::receiver) places.push_back(sight.receiver.position_m);
      }
    }
    // all of a ball's receivers stand at its centre
    places.erase(std::unique(places.begin(), places.end()), places.end());
    return places;
  }

  // Truth, exact visibility, all grids, target functions where they were asked for, and of baselines what a reader knows best.
  std::vector<ShownMethod> shown(size_t view) {
    std::vector<ShownMethod> row = {{pictureOf(ready_[view].surfaces.sights, "truth", ready_[view].truth.at), {}}};
    std::vector<std::string> wanted = {"exact visibility"};
    for (size_t m = 0; m < grid_count_; ++m) wanted.push_back(measured_[m].weights);
    wanted.insert(wanted.end(), {"target functions", "DDGI as shipped", "DDGI as shipped, backless sheets"});
    for (const std::string& name : wanted) {
      for (ShownMethod& method : pictures_[view]) {
        if (method.picture.method == name) row.push_back(method);
      }
    }
    return row;
  }

  std::vector<std::string> captionOf(size_t view) const {
    const ViewTruth& truth = ready_[view].truth;
    return {
        fmt::format("view {}, room {}{}", view + 1, views_.views[view].room + 1, views_.views[view].has_roof ? "" : ", no roof"),
        fmt::format("noise {:.1f} %, ", 100.0 * truth.median_noise) + (!truth.isLit() ? "no light, not counted"
                                                                       : !truth.isKnown()
                                                                           ? "not counted"
                                                                           : fmt::format("HyAB {:.1f}", truth.colour_noise))};
  }

  // That of the figures, which is truth's; where truth is not known, that of what has no noise.
  double exposureOf(size_t view, const std::vector<ShownMethod>& row) const {
    const ViewTruth& truth = ready_[view].truth;
    std::vector<const LitPicture*> pictures;
    pictures.reserve(row.size());
    for (const ShownMethod& method : row) pictures.push_back(&method.picture);
    return truth.isKnown() ? truth.exposure : panelExposure(pictures, truth.least);
  }

  std::string drawn(const std::string& name, const Image& image) const {
    return writePicture(image, request_.pictures, name, request_.out, "nlg-validate views");
  }

  Json results() {
    Json json = {{"rooms",
                  {{"count", views_.rooms},
                   {"without_floor", views_.rooms_without_floor},
                   {"dark", views_.rooms_dark},
                   {"left_out", views_.rooms_left_out}}},
                 {"truth",
                  {{"views", counted_views_},
                   {"noise", meanOf(&ViewTruth::noise)},
                   {"noise_median", meanOf(&ViewTruth::median_noise)},
                   {"hyab_noise", meanOf(&ViewTruth::colour_noise)}}},
                 {"methods", methodsJson(ofCounted())},
                 {"views", Json::array()}};
    std::vector<Image> rows;
    for (size_t v = 0; v < ready_.size(); ++v) {
      Json view = viewJson(views_.views[v], ready_[v].truth, measured_, v, scene_.source.scene.origin_m);
      view["truth"]["rays"] = ready_[v].truth_rays;
      if (!request_.pictures.empty()) {
        const std::vector<ShownMethod> row = shown(v);
        const std::vector<std::string> caption = captionOf(v);
        const double exposure = exposureOf(v, row);
        view["picture"] = drawn(viewName(v), viewRow(row, exposure, caption, request_.picture_scale));
        rows.push_back(viewRow(row, exposure, caption, (request_.picture_scale + 1) / 2));
      }
      json["views"].push_back(std::move(view));
    }
    if (!rows.empty()) {
      const std::string heading = fmt::format("{}, probes {:g} m apart", scene_.source.id, scene_.air.spacing_m);
      json["sheet"] = drawn(fileWord(scene_.source.id), contactSheet(rows, heading));
    }
    return json;
  }

  const Request& request_;
  const BakeOptions& options_;
  const PreparedScene& scene_;
  const int threads_;
  LightTransport transport_;
  SceneViews views_;
  std::vector<ReadyView> ready_;                         // by view
  size_t counted_views_ = 0;                             // whose truth is known
  std::vector<MeasuredViews> measured_;                  // by method
  size_t grid_count_ = 0;                                // of these, the first
  std::map<size_t, std::vector<ShownMethod>> pictures_;  // by view, all methods
};

void measureViews(Request request, BakeOptions options, const OptionTable& table) {
  takeThetaPrecision(&options);
  // nothing that is read may be overwritten
  std::vector<std::string> inputs = weightsPaths(request.weights);
  inputs.push_back(request.scene);
  inputs.insert(inputs.end(), request.grids.begin(), request.grids.end());
  refuseToReplace(request.out, inputs, kValidationFiles);
  requireOutputFile(request.out);
  // options are checked before truth is traced, which takes longest
  if (options.light == "none") throw UsageError("--light", "solved, integrated or point", "none, and a view needs light");
  if (!request.pictures.empty()) requireOutputFolder(request.pictures, "--pictures");
  if (request.truth.empty()) request.truth = std::filesystem::absolute(request.out).parent_path().string();
  requireOutputFolder(request.truth, "--truth");
  std::map<std::string, std::string> hashes;
  const GeneratorSets sets = loadSets(request.weights, &hashes);
  // views have a seed of their own: the bake's seed does not move cameras
  request.views.seed = mixSeed(kSeed, kViewStream);
  request.views.thread_count = options.threads > 0 ? options.threads : machineThreadCount();

  for (const std::string& path : request.grids) hashes["grid " + std::filesystem::path(path).stem().string()] = fileSha256(path);
  // the scene is read once for all methods
  const PreparedScene scene(request.scene, options);
  tellNotes("nlg-validate", scene.source);
  if (!scene.source.sha256.empty()) hashes["scene"] = scene.source.sha256;
  ViewsMeasurement measurement(request, options, scene);
  Json json = {{"schema_version", 1},
               {"provenance", provenance("nlg-validate views", table.usedJson(kWithoutEffect), hashes)},
               {"scene", scene.source.id},
               {"spacing_m", scene.air.spacing_m}};
  json.update(measurement.measure(sets));
  writeFileAtomically(request.out, json.dump(1) + "\n");
  std::cout << measurement.table() << request.out << '\n';
}

}  // namespace

int viewsMain(int argc, char** argv) {
  CLI::App app{
      "Draws views of a scene from where players stand, lit by truth and by every method, and measures the error of each "
      "picture:\n"
      "the grid with each of the given weights, exact visibility, trilinear blends, APV, DDGI.\n"
      "Settings of the bake: section bake of the configuration.",
      "nlg-validate views"};
  Request request;
  BakeOptions options;
  options.spacing_m = 0.0;  // chosen by the scene, as nlg-bake does
  OptionTable table("bake");
  describe(options, table);
  table.common({"weights", "spacing_m", "grids_only", "target_functions", "pictures", "most_views", "truth_rays", "threads"});
  app.add_option("scene", request.scene, "scene, as for nlg-bake")->required();
  app.add_option("--out", request.out, "result to write (.json)")->required();
  app.add_option(
      "--weights", request.weights,
      "exported generators, each for a bake of its own; several joined by commas are one bake that chooses among them");
  app.add_option("--grid", request.grids, "light grids of this scene, written by nlg-bake, to measure beside those baked here");
  app.add_option("--pictures", request.pictures,
                 "folder for pictures: for each view a row of truth and methods, and a sheet of all rows. None: no pictures");
  app.add_option("--truth", request.truth,
                 "folder in which truth is kept for other runs of the same views. None: beside the result");
  table.flagsAlone();
  table.add("cameras", &request.cameras, "use the scene's own cameras in place of views that are found");
  table.add("grids_only", &request.grids_only, "leave out baselines; exact visibility stays");
  table.add("target_functions", &request.target_functions,
            "add target functions, the functions that theta approximate, evaluated at every pixel; takes minutes");
  table.add("views_per_room", &request.views.views_per_room,
            "views per room; the three largest lit rooms under a roof have one more", 1, 100);
  table.add(
      "most_views", &request.views.most_views,
      "maximum number of views. Rooms under a roof come before outdoors, where more is lit before where less is, dark ones last",
      1, 1000);
  table.add("width", &request.views.width, "pixels of a view", 8, 4096);
  table.add("height", &request.views.height, "pixels of a view", 8, 4096);
  table.add("truth_rays", &request.truth_rays, "rays of ground truth per pixel in the first pass", 8, 1 << 20);
  table.add("truth_noise", &request.truth_noise,
            "noise of truth (standard deviation over light, median of pixels) above which a view gets up to eight times the rays",
            1e-3, 1e3);
  table.add("probe_rays", &request.probe_rays, "rays per probe of baselines", 8, 1 << 24);
  table.add("picture_scale", &request.picture_scale, "magnification of the pictures in a row; a sheet has half of it", 1, 8);
  return runTool(argc, argv, app, table, [&] { measureViews(request, options, table); });
}

}  // namespace nlg
