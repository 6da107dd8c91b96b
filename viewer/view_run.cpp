#include "viewer/view_run.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>

#include <fmt/format.h>

#include "bake/again/bake_provenance.h"
#include "export/shader/shader_export.h"
#include "light/air.h"
#include "render/camera.h"
#include "render/denoise.h"
#include "render/lit_picture.h"
#include "render/lit_views.h"
#include "render/place_picture.h"
#include "render/rendered_scene.h"
#include "render/tone.h"
#include "runtime_eval/grid_file/light_grid_file.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/numbers/rgb9e5.h"
#include "scene/model/surface_look.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/progress.h"
#include "tool/provenance.h"
#include "validate/light/light_figures.h"
#include "viewer/data_script.h"
#include "viewer/page.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr uint64_t kPlaceStream = 0x766965776572, kTruthStream = 0x7472757468;
constexpr double kFov = 1.0472;  // 60 degrees
constexpr double kAspect = 16.0 / 9.0;
constexpr int kPlaceRays = 256;  // of truth at a place
constexpr int kFewestPlaces = 16;
constexpr int kExposureWidth = 160, kExposureHeight = 90;
constexpr float kBrightestStored = 1000.0f;  // of a truth picture; RGB9E5 ends at 65,408
const std::vector<std::string> kShownBaselines = {"trilinear", "trilinear:solved", "valid-trilinear", "valid-trilinear:solved",
                                                  "ddgi"};

Json numbers(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

const OwnFiles kScripts = {"a script of a page of nlg-view",
                           [](std::string_view bytes) { return bytes.starts_with("nlgReceive(\""); }};
const OwnFiles kPages = {"a page of nlg-view", [](std::string_view bytes) {
                           return bytes.find("nlgReceive") != std::string_view::npos ||
                                  bytes.find("<title>light grid</title>") != std::string_view::npos;
                         }};

// A name among file names and in the page.
std::string scriptName(const std::string& method) {
  std::string name = method;
  std::replace(name.begin(), name.end(), ':', '-');
  return name;
}

struct View {
  std::string name;
  Camera camera;
};

// A camera of the scene's file is its author's choice, unless it shows less than so much of what the best view does: in the dark, or
// against a wall.
constexpr double kLeastWorthOfCamera = 0.3;

// Cameras of the scene's file, and then views that show most of what the grid lights: those of truth, or without any as many as there
// would be.
std::vector<View> chooseViews(const RenderedScene& scene, const ViewRequest& request, const BakeOptions& options) {
  LitViewOptions view_options{kFov, kAspect, options.seed, scene.threads()};
  LitViews found(scene.transport(), scene.light("grid"), lightExtent(scene.scene(), options.extent_m), view_options);
  const double least_worth = kLeastWorthOfCamera * found.bestWorth();
  std::vector<View> views;
  const int count = request.truth_views > 0 ? request.truth_views : ViewRequest().truth_views;
  const auto isFull = [&] { return views.size() >= static_cast<size_t>(count); };
  for (const Viewpoint& viewpoint : scene.scene().viewpoints) {
    if (!(viewpoint.fov_y > 0.0f) || isFull()) continue;
    const Camera camera = cameraAlong(glm::dvec3(viewpoint.position), glm::dvec3(viewpoint.forward), viewpoint.fov_y);
    if (found.worthOf(camera) < least_worth) continue;
    found.take(camera);
    views.push_back({viewpoint.name, camera});
  }
  while (!isFull()) views.push_back({fmt::format("view {}", views.size() + 1), found.takeBest()});
  return views;
}

Sights sights(const LightTransport& transport, const Camera& camera, int width, int height, int threads) {
  SightOptions options;
  options.width = width;
  options.height = height;
  options.samples_per_side = 1;
  options.thread_count = threads;
  return sightsOf(transport, camera, options);
}

class ViewFolder {
 public:
  ViewFolder(const ViewRequest& request, const BakeOptions& options, const RenderRequest& render)
      : request_(request), options_(options), scene_(render, options), grid_(scene_.grid()) {
    const glm::dvec3& origin_m = scene_.scene().origin_m;
    grid_.tree.moveBy({-origin_m.x, -origin_m.y, -origin_m.z});
    said_ = {{"schema_version", 1}, {"scene", scene_.id()}, {"out", request.out}};
  }

  Json write() {
    // the page last: it is there when all that it reads is, and one of an earlier run goes first
    std::error_code gone;
    fs::remove(page(), gone);
    const std::vector<View> views = chooseViews(scene_, request_, options_);
    DataScript script("scene");
    addGeometry(&script);
    addFacts(&script);
    script.facts["views"] = Json::array();
    for (const View& view : views) script.facts["views"].push_back(placeJson(view.name, view.camera));
    std::vector<uint8_t> in_air;
    for (size_t p = 0; p < grid_.tree.probeCount(); ++p) {
      const PositionM at = grid_.tree.probePosition(p);
      in_air.push_back(isInAir(scene_.transport().rays(), {at[0], at[1], at[2]}));
    }
    write(probesScript(grid_, in_air));
    write(gridScript("method-grid", grid_));
    if (request_.truth_views > 0 || request_.places > 0 || !request_.baselines.empty()) writeFirstPage(script);
    if (request_.truth_views > 0) writeTruths(views);
    script.facts["has_truth"] = request_.truth_views > 0;
    addMethods(&script);
    writePage(script);
    removeOthers();
    said_["page"] = page();
    return said_;
  }

 private:
  std::string page() const { return (fs::path(request_.out) / "index.html").string(); }

  // The grid alone, which is there long before what it is compared with.
  void writeFirstPage(DataScript script) {
    script.facts["has_truth"] = false;
    script.facts["warnings"].push_back(
        "Not here yet: baselines, path tracing and errors. nlg-view still computes them: reload when it has ended.");
    script.facts["methods"] = Json::array({gridEntry()});
    script.facts["air_samples"] = script.facts["surface_samples"] = 0;
    script.facts["worst"] = Json::array();
    writePage(script);
    std::cerr << "open " << page() << ": the light grid; baselines, path tracing and errors follow\n";
  }

  void writeTruths(const std::vector<View>& views) {
    Progress views_done("views", static_cast<int64_t>(views.size()));
    for (size_t v = 0; v < views.size(); ++v) {
      views_done.update(static_cast<int64_t>(v));
      write(truthScript(v, views[v].camera));
    }
  }

  void writePage(const DataScript& script) {
    write(script);
    for (const PageFile& file : pageFiles()) writeText(file.name, file.text);
  }

  // What a run before left that this one has not.
  void removeOthers() const {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(request_.out, error)) {
      const std::string name = entry.path().filename().string();
      const bool is_named = (name.starts_with("method-") || name.starts_with("truth-")) && name.ends_with(".js");
      if (is_named && !said_["files"].contains(name) && mayReplace(entry.path().string(), kScripts))
        fs::remove(entry.path(), error);
    }
  }

  void writeText(std::string_view name, std::string_view text) {
    writeFileAtomically((fs::path(request_.out) / name).string(), text);
    said_["files"][std::string(name)] = text.size();
  }
  void write(const DataScript& script) { writeText(script.name() + ".js", script.text()); }

  void addGeometry(DataScript* script) {
    const Scene& scene = scene_.scene();
    std::vector<float> positions, albedo, sky_positions, sky_shine;
    const auto append = [](std::vector<float>* to, const glm::vec3& v) { to->insert(to->end(), {v.x, v.y, v.z}); };
    std::vector<uint32_t> triangles;
    for (const glm::vec3& position : scene.positions) append(&positions, position);
    for (const glm::uvec3& t : scene.triangles) triangles.insert(triangles.end(), {t.x, t.y, t.z});
    for (const Material& material : scene.materials) append(&albedo, albedoOf(material, material.base_color));
    const SkyFaces& faces = scene.light.sky_faces;
    for (size_t t = 0; t < faces.triangles.size(); ++t) {
      for (int corner = 0; corner < 3; ++corner) append(&sky_positions, faces.positions[faces.triangles[t][corner]]);
      const bool shines = faces.shines(static_cast<uint32_t>(t));
      // below 0: the sky itself
      append(&sky_shine, shines ? faces.shine[t + faces.shine.size() - faces.triangles.size()] : glm::vec3(-1.0f));
    }
    script->add("positions", positions);
    script->add("triangles", triangles);
    script->add("triangle_material", scene.triangle_material);
    script->add("albedo", albedo);
    addLooks(scene, script);
    script->add("sky_positions", sky_positions);
    script->add("sky_shine", sky_shine);
    addShine(script);
    said_["triangles"] = scene.triangles.size();
  }

  void addFacts(DataScript* script) const {
    Json& facts = script->facts;
    facts["scene"] = scene_.id();
    facts["revision"] = sourceRevision();
    facts["origin_m"] = numbers(scene_.scene().origin_m);
    facts["look_up"] = kLookUpText;
    facts["light"] = scene_.lightNotes();
    facts["warnings"] = scene_.warnings();
    facts["starts"] = Json::array();
    for (const Viewpoint& viewpoint : scene_.scene().viewpoints) {
      if (viewpoint.fov_y > 0.0f) continue;
      facts["starts"].push_back(
          placeJson(viewpoint.name, cameraAlong(glm::dvec3(viewpoint.position), glm::dvec3(viewpoint.forward), kFov)));
    }
  }

  // What is seen to shine: sky, and materials, each with the group of light that it is of.
  void addShine(DataScript* script) {
    const Scene& scene = scene_.scene();
    const LightGroups& groups = scene.light.groups;
    const Sky& sky = scene.light.sky;
    script->facts["light_groups"] = groups.names;
    script->facts["skies"] = {{{"group", groups.names.empty() ? "sky" : groups.names[groups.of_sky]},
                               {"zenith", numbers(sky.zenith)},
                               {"horizon", numbers(sky.horizon)},
                               {"ground", numbers(sky.ground)}}};
    std::vector<float> emissive;
    std::vector<uint8_t> group_of_material;
    for (size_t m = 0; m < scene.materials.size(); ++m) {
      for (int c = 0; c < 3; ++c) emissive.push_back(scene.materials[m].emissive[c]);
      group_of_material.push_back(LightGroups::of(groups.of_material, m));
    }
    script->add("emissive_0", emissive);
    script->add("emissive_groups_0", group_of_material);
  }

  // A place to go to, with the exposure that its own view asks for, lit by the grid.
  Json placeJson(const std::string& name, const Camera& camera) const {
    const Sights seen = sights(scene_.transport(), camera, kExposureWidth, kExposureHeight, scene_.threads());
    return {{"name", name},
            {"eye", numbers(camera.eye_m)},
            {"forward", numbers(glm::dvec3(camera.forward))},
            {"fov_y", camera.fov_y},
            {"exposure", automaticExposure(lightPicture(seen, "grid", scene_.light("grid"), scene_.threads()),
                                           leastAdapted(scene_.scene()))}};
  }

  DataScript truthScript(size_t view, const Camera& camera) const {
    const int width = request_.truth_width, height = width * 9 / 16;
    const Sights seen = sights(scene_.transport(), camera, width, height, scene_.threads());
    // shown only: figures are measured where nothing is filtered
    const std::vector<LightAnswer> received =
        denoised(seen, camera, lightSamples(seen, scene_.light("truth"), scene_.threads()), scene_.threads());
    const LitPicture picture = pictureOf(seen, "truth", received);
    float brightest = 0.0f;
    for (const glm::vec3& radiance : picture.radiance) brightest = std::max({brightest, radiance.r, radiance.g, radiance.b});
    const float unit = brightest > 0.0f ? brightest / kBrightestStored : 1.0f;
    std::vector<uint32_t> texels;
    texels.reserve(picture.radiance.size());
    for (const glm::vec3& radiance : picture.radiance)
      texels.push_back(rgb9e5FromFloats({radiance.r / unit, radiance.g / unit, radiance.b / unit}));
    DataScript script(fmt::format("truth-{}", view));
    script.facts = {{"width", width}, {"height", height}, {"unit", unit}, {"rays", request_.truth_rays}};
    script.add("texels", texels);
    return script;
  }

  struct Measured {
    LightPlaces places;
    LightTruth truth;
  };

  Measured measureTruth() const {
    LightPlaceOptions options;
    options.air = options.surface = static_cast<uint64_t>(request_.places) / 2;
    options.walks = 1;
    options.edges = 0;
    options.seed = mixSeed(options_.seed, kPlaceStream);
    TruthOptions truth;
    truth.gather.rays = kPlaceRays;
    truth.gather.direct = directLightFromName(options_.light_direct);
    truth.seed = mixSeed(options_.seed, kTruthStream);
    truth.threads = scene_.threads();
    const LightTransport& transport = scene_.transport();
    Measured measured;
    measured.places = drawLightPlaces(scene_.scene(), transport.rays(), lightExtent(scene_.scene(), options_.extent_m), options);
    measured.truth = lightTruth(measured.places, transport, truth);
    return measured;
  }

  LightFigures figuresOf(const Measured& measured, const std::string& method) const {
    return lightFigures(measured.places, measured.truth,
                        answersAt(scene_.light(method), receiversAt(measured.places), scene_.threads()));
  }

  static Json entryOf(const std::string& name, const std::string& title, size_t bytes, size_t probes) {
    return {{"name", scriptName(name)}, {"title", title}, {"bytes", bytes}, {"probes", probes}};
  }
  Json gridEntry() const {
    const size_t bytes = request_.grid.empty()
                             ? lightGridBytes(grid_, {options_.policy.theta_precision, options_.light_error}).total()
                             : fs::file_size(request_.grid);
    return entryOf("grid", "light grid", bytes, grid_.tree.probeCount());
  }

  void addMethods(DataScript* script) {
    const Measured measured = request_.places > 0 ? measureTruth() : Measured{};
    script->facts["methods"] = Json::array();
    const auto add = [&](const std::string& name, Json entry) {
      LightFigures figures;
      if (request_.places > 0) {
        figures = figuresOf(measured, name);
        entry["rmse_air"] = figures.air.rmse;
        entry["rmse_surface"] = figures.surface.rmse;
      }
      script->facts["methods"].push_back(entry);
      said_["methods"].push_back(entry);
      return figures;
    };
    const LightFigures ours = add("grid", gridEntry());
    script->facts["air_samples"] = ours.air.places;
    script->facts["surface_samples"] = ours.surface.places;
    script->facts["worst"] = Json::array();
    for (size_t i = 0; i < ours.worst.size(); ++i) {
      const WorstPlace& worst = ours.worst[i];
      const LightPlace& place = measured.places.places[worst.place];
      Json entry =
          placeJson(fmt::format("worst {}", i + 1), viewOfPlace(scene_.transport(), {place.position_m, place.normal}).camera);
      entry["place"] = numbers(place.position_m);
      entry["normal"] = numbers(glm::dvec3(place.normal));
      entry["error"] = worst.error;
      script->facts["worst"].push_back(entry);
    }
    for (const std::string& name : request_.baselines) {
      const LightMethod& baseline = scene_.baseline(name);
      add(name, entryOf(name, titleOf(name), baseline.bytes.total(), baseline.probes));
      write(baselineScript(name, baseline));
    }
  }

  static std::string titleOf(const std::string& name) {
    if (name == "ddgi") return "DDGI";
    const std::string solved = name.ends_with(":solved") ? ", light solved for" : "";
    return (name.starts_with("valid") ? "trilinear, without probes in walls" : "trilinear, all probes") + solved;
  }

  DataScript baselineScript(const std::string& name, const LightMethod& baseline) const {
    DataScript script =
        name == "ddgi"
            ? ddgiScript(scene_.baselines().probes(), *scene_.baselines().shippedDdgi())
            : gridScript(name, trilinearGrid(scene_.baselines().probes(), *baseline.probe_light, !name.starts_with("valid")));
    script.rename("method-" + scriptName(name));
    return script;
  }

  const ViewRequest& request_;
  const BakeOptions& options_;
  const RenderedScene scene_;
  LightGrid grid_;  // in the scene's coordinates
  Json said_;
};

}  // namespace

std::string folderOfView(const std::string& scene) {
  const fs::path path(scene);
  // house:3 has no ending, and is house_3
  std::string name = (formatOf(scene) != nullptr ? path.stem() : path.filename()).string();
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

void refuseToReplaceOthersOf(const ViewRequest& request) {
  const fs::path folder(request.out);
  for (const PageFile& file : pageFiles()) refuseToReplaceOthers((folder / file.name).string(), kPages);
  std::vector<std::string> scripts = {"scene", "probes", "method-grid"};
  for (const std::string& baseline : request.baselines) scripts.push_back("method-" + scriptName(baseline));
  for (int view = 0; view < request.truth_views; ++view) scripts.push_back(fmt::format("truth-{}", view));
  for (const std::string& script : scripts) refuseToReplaceOthers((folder / (script + ".js")).string(), kScripts);
}

void describe(ViewRequest& r, CLI::App& app) {
  app.add_option("scene", r.scene, "scene, as for nlg-bake")->required();
  app.add_option("--out", r.out,
                 "folder to write; its page is index.html. None: a folder of the scene's name in the current folder");
  app.add_option("--grid", r.grid, "light grid that holds light, of nlg-bake. None: the scene is baked");
  app.add_option("--weights", r.weights, "weights for the bake. None: the supplied weights");
  app.add_option("--baselines", r.baselines,
                 "baselines beside the grid, at its probe spacing: trilinear, valid-trilinear, ddgi, or none. trilinear:solved "
                 "and valid-trilinear:solved have solved light")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--truth-views", r.truth_views, "number of views whose ground truth is stored. 0: none")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  app.add_option("--truth-width", r.truth_width, "width of ground truth, pixels. The height is 9/16 of it")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  app.add_option("--truth-rays", r.truth_rays, "rays of ground truth per pixel")
      ->check(CLI::Range(8, 1 << 20))
      ->capture_default_str();
  app.add_option("--truth-samples", r.places,
                 "number of sample points at which methods are compared with ground truth, half in air, half before surfaces. 0: "
                 "no comparison")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  app.add_flag("--watch", r.is_watched,
               "keep running, bake again whenever the scene's files are saved, and update the open page, which a server on this "
               "machine serves. --grid names the grid to keep up to date. Baselines, ground truth and sample points are left out "
               "unless asked for");
  app.add_option("--port", r.port, "port of the server of --watch. 0: any free port")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
}

Json makeView(ViewRequest request, BakeOptions options) {
  // the scene's name is the folder's, unless --out says another
  if (request.out.empty()) request.out = folderOfView(request.scene);
  requireOutputFolder(request.out);
  // options are checked before the bake, which takes longest
  if (request.baselines == std::vector<std::string>{"none"}) request.baselines.clear();
  for (const std::string& name : request.baselines) {
    if (std::count(request.baselines.begin(), request.baselines.end(), name) > 1)
      throw UsageError("--baselines", "each once", "'" + name + "' twice");
    if (std::find(kShownBaselines.begin(), kShownBaselines.end(), name) == kShownBaselines.end())
      throw UsageError("--baselines", fmt::format("{}, or none", fmt::join(kShownBaselines, ", ")), "'" + name + "'");
  }
  if (request.places > 0 && request.places < kFewestPlaces)
    throw UsageError("--truth-samples", fmt::format("0, or {} or more", kFewestPlaces), std::to_string(request.places));
  // pages of this tool are replaced, other files never
  std::vector<std::string> inputs = {request.scene, request.grid};
  inputs.insert(inputs.end(), request.weights.begin(), request.weights.end());
  for (const PageFile& file : pageFiles()) refuseToReplaceInputs((fs::path(request.out) / file.name).string(), inputs);
  refuseToReplaceOthersOf(request);
  if (!request.grid.empty() && !request.weights.empty())
    throw UsageError("--weights cannot be combined with --grid: nothing is baked");
  if (!request.grid.empty()) {
    const BakedGrid baked = readLitGrid(request.grid);
    const double spacing_m = bakedSpacing(baked.grid, baked.metadata);
    // probes stand as far apart as the nearest float says
    const bool is_other = static_cast<float>(options.spacing_m) != static_cast<float>(spacing_m);
    if (options.spacing_m != 0.0 && is_other)
      throw UsageError("spacing_m", fmt::format("{:g}, as in --grid", spacing_m), fmt::format("{:g}", options.spacing_m));
    options.spacing_m = spacing_m;
  }
  // the page's methods are drawn by the renderer: it gets the same request
  RenderRequest render;
  render.program = "nlg-view";
  render.panel_flag = "--baselines";
  render.scene = request.scene;
  render.grid = request.grid;
  render.bake = request.grid.empty();
  render.weights = request.weights;
  render.truth_rays = request.truth_rays;
  render.panel = request.baselines;
  render.panel.insert(render.panel.begin(), {"truth", "grid"});
  return ViewFolder(request, options, render).write();
}

}  // namespace nlg
