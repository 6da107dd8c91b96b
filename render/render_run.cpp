#include "render/render_run.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "light/air.h"
#include "render/camera.h"
#include "render/lit_picture.h"
#include "render/panel.h"
#include "render/picture/image.h"
#include "render/picture/legend.h"
#include "render/rendered_scene.h"
#include "render/tone.h"
#include "tool/error.h"
#include "tool/output_path.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDefaultFov = 60.0;  // degrees
constexpr double kDegree = std::numbers::pi / 180.0;
// CLI::Range lets through what is not a number.
CLI::Validator numberIn(double low, double high) {
  return {[low, high](std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            if (end != text.c_str() && *end == '\0' && value >= low && value <= high) return std::string();
            return fmt::format("expected a number from {} to {}, got '{}'", low, high, text);
          },
          fmt::format("FLOAT in [{} - {}]", low, high)};
}

constexpr const char* kTone = "radiance x exposure, Khronos PBR Neutral, sRGB";

Json numbers(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
glm::dvec3 vectorOf(const std::vector<double>& three) { return {three[0], three[1], three[2]}; }

void check(const RenderRequest& request) {
  for (const std::string& name : methodNames(request)) {
    checkMethodName(request.panel.empty() ? "--method" : "--panel", name);
  }
  const std::vector<std::string> shows = {"light", "error", "absolute"};
  if (std::find(shows.begin(), shows.end(), request.show) == shows.end())
    throw UsageError("--show", "light, error or absolute", "'" + request.show + "'");
  if (asksFor(request, "grid") && request.grid.empty() && !request.bake)
    throw UsageError("a light grid is needed: give --grid GRID, or --bake");
  if (request.bake && !request.grid.empty()) throw UsageError("--bake cannot be combined with --grid");
  if (!request.look.empty() && request.eye.empty()) throw UsageError("--look needs --eye");
  if (!request.camera.empty() && !request.eye.empty()) throw UsageError("--camera cannot be combined with --eye");
  if (request.eye.empty() != request.look.empty()) throw UsageError("--eye needs --look");
  if (!request.eye.empty() && !(glm::length(vectorOf(request.look) - vectorOf(request.eye)) > 1e-9))
    throw UsageError("--look and --eye are the same point");
}

double askedFov(const RenderRequest& request) { return (request.fov > 0.0 ? request.fov : kDefaultFov) * kDegree; }

// Its own angle of view, unless another is asked for.
Camera cameraAt(const Viewpoint& viewpoint, const RenderRequest& request) {
  const bool is_camera = viewpoint.fov_y > 0.0f && request.fov == 0.0;
  return {glm::dvec3(viewpoint.position), viewpoint.forward, viewpoint.up, is_camera ? viewpoint.fov_y : askedFov(request)};
}

// By name, or by number from 0.
const Viewpoint& namedViewpoint(const std::string& name, const Scene& scene) {
  std::string known;
  for (size_t i = 0; i < scene.viewpoints.size(); ++i) {
    const Viewpoint& viewpoint = scene.viewpoints[i];
    if (viewpoint.name == name || std::to_string(i) == name) return viewpoint;
    if (i < 8) known += (i > 0 ? ", '" : "'") + viewpoint.name + "'";
  }
  throw UsageError("--camera", known.empty() ? "a scene that has cameras" : "one of " + known + ", or its number",
                   "'" + name + "'");
}

Camera cameraOf(const RenderRequest& request, const BakeOptions& options, const RenderedScene& scene) {
  const double fov_y = askedFov(request);
  if (!request.eye.empty()) {
    const glm::dvec3 eye = vectorOf(request.eye);
    return cameraAlong(eye - scene.scene().origin_m, vectorOf(request.look) - eye, fov_y);
  }
  if (!request.camera.empty()) return cameraAt(namedViewpoint(request.camera, scene.scene()), request);
  for (const Viewpoint& viewpoint : scene.scene().viewpoints) {
    if (viewpoint.fov_y > 0.0f) return cameraAt(viewpoint, request);
  }
  return chooseView(scene.transport(), fov_y, static_cast<double>(request.width) / request.height, options.seed);
}

Cut cutOf(const RenderRequest& request, const Scene& scene) {
  const Bounds bounds = boundsWithSky(scene);
  Cut cut{glm::dvec3(bounds.min), glm::dvec3(bounds.max)};
  const double y = request.slice_y[0] - scene.origin_m.y;
  if (!(y >= cut.low_m.y && y <= cut.high_m.y)) {
    throw UsageError("--slice-y",
                     fmt::format("a height in the scene, from {:g} to {:g} m", cut.low_m.y + scene.origin_m.y,
                                 cut.high_m.y + scene.origin_m.y),
                     fmt::format("{:g}", request.slice_y[0]));
  }
  cut.low_m.y = cut.high_m.y = y;
  return cut;
}

// One run: what it draws, and what it says of it.
class Rendering {
 public:
  Rendering(const RenderRequest& request, const BakeOptions& options)
      : request_(request), options_(options), scene_(request, options) {
    said_ = {{"schema_version", 1}, {"scene", scene_.id()}, {"light", scene_.lightNotes()}};
    see();
  }

  Json draw() {
    const Image image = drawMethods();
    said_["tone"] = kTone;
    said_["width"] = image.width();
    said_["height"] = image.height();
    PngTexts texts = {{"Software", std::string("nlg-render ") + sourceRevision()}, {"Description", said_.dump()}};
    if (said_.contains("exposure")) texts["Exposure"] = said_["exposure"].dump();
    writePng(request_.out, image, texts);
    return std::move(said_);
  }

 private:
  void see() {
    const glm::dvec3& origin_m = scene_.scene().origin_m;
    if (!request_.slice_y.empty()) {
      sights_ = sightsOfCut(scene_.transport(), cutOf(request_, scene_.scene()), request_.width, scene_.threads());
      said_["slice_y_m"] = request_.slice_y[0];
      place_ = fmt::format("cut at y = {:g} m, seen from above, lit on a white plane that faces up", request_.slice_y[0]);
      return;
    }
    const Camera camera = cameraOf(request_, options_, scene_);
    SightOptions sight;
    sight.width = request_.width;
    sight.height = request_.height;
    sight.samples_per_side = request_.samples;
    sight.offset_m = request_.offset_m;
    sight.thread_count = scene_.threads();
    sights_ = sightsOf(scene_.transport(), camera, sight);
    const glm::dvec3 eye = origin_m + camera.eye_m, look = eye + glm::dvec3(camera.forward);
    said_["camera"] = {{"eye_m", numbers(eye)}, {"look_m", numbers(look)}, {"fov_degrees", camera.fov_y / kDegree}};
    place_ = "from " + positionText(eye) + " towards " + positionText(look);
  }

  LitPicture lit(const std::string& method, const LightAt& light_at) const {
    return lightPicture(sights_, method, light_at, scene_.threads());
  }

  Image drawMethods() {
    const bool shows_error = request_.show != "light";
    const bool needs_truth = shows_error || asksFor(request_, "truth");
    std::optional<LitPicture> truth;
    if (needs_truth) truth = lit("truth", scene_.light("truth"));
    std::vector<LitPicture> pictures;
    for (const std::string& name : methodNames(request_)) {
      pictures.push_back(name == "truth" ? *truth : lit(name, scene_.light(name)));
      said_["pictures"].push_back(figuresOf(pictures.back(), truth));
    }
    std::vector<const LitPicture*> shown;
    shown.reserve(pictures.size());
    for (const LitPicture& picture : pictures) shown.push_back(&picture);
    const double exposure = request_.exposure > 0.0 ? request_.exposure : panelExposure(shown, leastAdapted(scene_.scene()));
    said_["exposure"] = exposure;
    said_["exposure_is_automatic"] = !(request_.exposure > 0.0);
    const ErrorKind kind = request_.show == "absolute" ? ErrorKind::absolute : ErrorKind::with_sign;
    double range = request_.error_range;
    if (truth && !(range > 0.0)) {
      std::vector<const LitPicture*> others;
      for (const LitPicture& picture : pictures) {
        if (picture.method != "truth") others.push_back(&picture);
      }
      range = errorRange(others, *truth);
    }
    if (truth) said_["error_range"] = range;
    if (!request_.panel.empty()) return drawColumns(pictures, truth, exposure, kind, range);
    if (shows_error) return withErrorBar(errorMap(pictures[0], *truth, kind, range), kind, range);
    return toneMapped(pictures[0], exposure);
  }

  static Json figuresOf(const LitPicture& picture, const std::optional<LitPicture>& truth) {
    Json figures = {{"method", picture.method}, {"unlit_share", picture.unlit_share}};
    if (!truth) return figures;
    const PictureError error = pictureError(picture, *truth);
    if (picture.method != "truth") figures.update({{"rmse", error.rmse}, {"bias", error.bias}});
    if (picture.method == "truth") figures["noise"] = error.truth_noise;
    return figures;
  }

  Image drawColumns(const std::vector<LitPicture>& pictures, const std::optional<LitPicture>& truth, double exposure,
                    ErrorKind kind, double range) const {
    std::vector<PanelColumn> columns;
    for (size_t i = 0; i < pictures.size(); ++i) {
      const LitPicture& picture = pictures[i];
      const Json& figures = said_["pictures"][i];
      PanelColumn column{picture.method, {}, toneMapped(picture, exposure), std::nullopt};
      if (picture.method == "truth") {
        column.captions.push_back(
            fmt::format("{} rays a sample, noise {:.3f}", request_.truth_rays, figures["noise"].get<double>()));
      } else if (truth) {
        column.captions.push_back(
            fmt::format("RMSE {:.3f}, mean error {:+.3f}", figures["rmse"].get<double>(), figures["bias"].get<double>()));
        column.error = errorMap(picture, *truth, kind, range);
      }
      if (picture.unlit_share > 0.0)
        column.captions.push_back(fmt::format("unlit: {:.2f} % of the samples", 100.0 * picture.unlit_share));
      columns.push_back(std::move(column));
    }
    return drawPanel(
        columns,
        {{scene_.id(), place_, fmt::format("exposure {:.4g}; errors of irradiance over truth's RMS", exposure)}, kind, range});
  }

  const RenderRequest& request_;
  const BakeOptions& options_;
  RenderedScene scene_;
  Sights sights_;
  std::string place_;
  Json said_;
};

}  // namespace

std::vector<std::string> methodNames(const RenderRequest& request) {
  return request.panel.empty() ? std::vector<std::string>{request.method} : request.panel;
}

bool asksFor(const RenderRequest& request, const std::string& method) {
  const std::vector<std::string> names = methodNames(request);
  return std::find(names.begin(), names.end(), method) != names.end();
}

void describe(RenderRequest& r, CLI::App& app) {
  app.add_option("scene", r.scene, "scene, as for nlg-bake")->required();
  app.add_option("--out", r.out, "picture to write (.png)")->required();
  app.add_option("--grid", r.grid, "light grid that holds light, of nlg-bake");
  app.add_flag("--bake", r.bake, "bake the light grid with the settings of nlg-bake instead of reading one");
  app.add_option("--weights", r.weights, "weights for --bake. None: the supplied weights");
  app.add_option("--method", r.method,
                 "method that lights the picture: truth, grid, or a baseline: " + baselineNames() +
                     "; with :solved appended, its light is solved")
      ->capture_default_str();
  app.add_option("--panel", r.panel, "methods to draw side by side, with titles, and with errors if truth is among them")
      ->delimiter(',');
  app.add_option("--show", r.show,
                 "what the picture shows: light; error, signed, of irradiance; or absolute, the error's magnitude")
      ->capture_default_str();
  app.add_option("--truth-rays", r.truth_rays, "rays of ground truth per sample")
      ->check(CLI::Range(8, 1 << 20))
      ->capture_default_str();
  app.add_option("--exposure", r.exposure,
                 "factor on radiance. 0: the median luminance of the first method without noise, or else of truth, becomes .18; "
                 "it stays darker where it is below a ten-thousandth of the scene's brightest source")
      ->check(numberIn(0.0, 1e12))
      ->capture_default_str();
  app.add_option("--error-range", r.error_range,
                 "error, as a share of truth's root mean square, that has the last colour. 0: chosen from the picture")
      ->check(numberIn(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--camera", r.camera,
                 "camera: its name or number, from 0, in the glTF file, or the number of a player start of the level. None: the "
                 "file's first camera, or a chosen view");
  app.add_option("--eye", r.eye, "position of the camera: --eye=x,y,z, world coordinates, metres")->delimiter(',')->expected(3);
  app.add_option("--look", r.look, "point that the camera looks at: --look=x,y,z, world coordinates, metres")
      ->delimiter(',')
      ->expected(3);
  app.add_option("--fov", r.fov, "vertical field of view, degrees. 0: the camera's own, or 60")
      ->check(numberIn(0.0, 170.0))
      ->capture_default_str();
  app.add_option("--slice-y", r.slice_y, "height of a cut, metres, drawn from above instead of a view")->expected(1);
  app.add_option("--width", r.width, "pixels of one picture")->check(CLI::Range(8, 16384))->capture_default_str();
  app.add_option("--height", r.height, "height of one picture, pixels. A cut's height follows from its width")
      ->check(CLI::Range(8, 16384))
      ->capture_default_str();
  app.add_option("--samples", r.samples, "samples per pixel along each axis")->check(CLI::Range(1, 16))->capture_default_str();
  app.add_option("--offset-m", r.offset_m,
                 "distance before a surface at which light is looked up, metres; half way where something is nearer")
      ->check(numberIn(0.0, 10.0))
      ->capture_default_str();
}

Json renderScene(const RenderRequest& request, const BakeOptions& options) {
  check(request);
  std::vector<std::string> inputs = {request.scene, request.grid};
  inputs.insert(inputs.end(), request.weights.begin(), request.weights.end());
  refuseToReplace(request.out, inputs, kPictures);
  return Rendering(request, options).draw();
}

}  // namespace nlg
