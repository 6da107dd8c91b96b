#include "validate/views/view_truth.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include <fmt/format.h>

#include "light/directions.h"
#include "light/sunlight.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/weights_file/tensor_file.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr int kTurns = 16;  // of short rays around a normal

// Short rays along the surface's plane, all around.
bool risesBeside(const RayScene& rays, const Receiver& receiver) {
  for (int turn = 0; turn < kTurns; ++turn) {
    const glm::dvec3 along(aroundAxis(receiver.normal, 0.0f, static_cast<double>(turn) / kTurns));
    if (rays.isBlocked(glm::vec3(receiver.position_m), glm::vec3(receiver.position_m + kEdgeM * along))) return true;
  }
  return false;
}

uint8_t bitOf(ViewClass of_class) { return static_cast<uint8_t>(1 << static_cast<int>(of_class)); }

uint8_t classesOf(const LightTransport& transport, const Receiver& receiver, bool is_on_figure) {
  uint8_t classes = bitOf(ViewClass::all);
  const RayScene& rays = transport.rays();
  if (is_on_figure) classes |= bitOf(ViewClass::figure);
  if (!is_on_figure && risesBeside(rays, receiver)) classes |= bitOf(ViewClass::edge);
  const Scene& scene = transport.scene();
  const bool is_in_shadow = !scene.light.suns.empty() && !isInSunlight(scene, rays, receiver.position_m, receiver.normal);
  return is_in_shadow ? classes | bitOf(ViewClass::shadow) : classes;
}

constexpr const char* kKey = "truth_of";

std::string keyOf(const Sights& sights, const ViewTruthOptions& options) {
  std::string text = fmt::format("truth {} of {}, noise {} by {} rounds, {} rays, {} bounces, light {}, seed {}\n", kTruthVersion,
                                 options.scene_sha256, options.noise, kMostTruthRounds, options.gather.rays,
                                 options.gather.max_bounces, static_cast<int>(options.gather.direct), options.seed);
  const auto append = [&](const auto& v) { text.append(reinterpret_cast<const char*>(&v), sizeof v); };
  for (const Sight& sight : sights.samples) {
    append(sight.kind);
    if (sight.kind != Sight::Kind::receiver) continue;
    append(sight.receiver.position_m);
    append(sight.receiver.normal);
  }
  return sha256(text);
}

// A view without rounds unless the file is of this very truth, and whole.
// why   receives what is wrong with a file that is there
TracedView readTruth(const std::string& path, const std::string& key, size_t samples, std::string* why) {
  TensorFileReader reader;
  std::vector<float> irradiance, deviation;
  std::vector<int32_t> rounds;
  // the key is a digest of scene, view and settings: another key is another truth
  FileResult result = reader.openFile(path);
  if (result.ok()) {
    const auto found = reader.metadata().find(kKey);
    if (!reader.hasDigest() || found == reader.metadata().end() || found->second != key) {
      *why = "of another scene, view or setting";
      return {};
    }
    result = reader.read("irradiance", &irradiance);
  }
  if (result.ok()) result = reader.read("deviation", &deviation);
  if (result.ok()) result = reader.read("rounds", &rounds);
  // a file cut short, or of another size, is no truth
  if (!result.ok() || irradiance.size() != 3 * samples || deviation.size() != 3 * samples || rounds.size() != 1) {
    *why = result.ok() ? "of another size" : result.detail;
    return {};
  }
  // both hold three floats a sample: red, green, blue
  TracedView view;
  view.at.resize(samples);
  view.rounds = rounds.front();
  view.was_read = true;
  for (size_t i = 0; i < samples; ++i) {
    view.at[i] = {{irradiance[3 * i], irradiance[3 * i + 1], irradiance[3 * i + 2]},
                  Reach::lit,
                  {deviation[3 * i], deviation[3 * i + 1], deviation[3 * i + 2]}};
  }
  return view;
}

void writeTruth(const std::string& path, const std::string& key, const TracedView& view) {
  std::vector<float> irradiance, deviation;
  for (const LightAnswer& light : view.at) {
    irradiance.insert(irradiance.end(), {light.irradiance.r, light.irradiance.g, light.irradiance.b});
    deviation.insert(deviation.end(), {light.deviation.r, light.deviation.g, light.deviation.b});
  }
  const std::vector<int32_t> rounds = {view.rounds};
  TensorFileWriter writer;
  writer.add("irradiance", irradiance);
  writer.add("deviation", deviation);
  writer.add("rounds", rounds);
  std::string bytes;
  const FileResult result = writer.serialize({{kKey, key}}, &bytes);
  NLG_CHECK(result.ok(), ==, true);
  writeFileAtomically(path, bytes);
}

TracedView traced(const LightTransport& transport, const Sights& sights, const ViewTruthOptions& options) {
  const auto round = [&](int number) {
    return lightSamples(sights, trueLight(transport, options.gather, mixSeed(options.seed, number)), options.thread_count);
  };
  TracedView view;
  view.at = round(0);
  // noise falls with the root of the rounds
  const double over = medianNoise(view.at) / options.noise;
  view.rounds = static_cast<int>(std::clamp(std::ceil(over * over), 1.0, double{kMostTruthRounds}));
  // variances add, deviations do not
  for (LightAnswer& at : view.at) at.deviation *= at.deviation;
  for (int number = 1; number < view.rounds; ++number) {
    const std::vector<LightAnswer> more = round(number);
    for (size_t i = 0; i < more.size(); ++i) {
      view.at[i].irradiance += more[i].irradiance;
      view.at[i].deviation += more[i].deviation * more[i].deviation;
    }
  }
  // mean of the rounds, and its deviation
  const auto share = 1.0f / static_cast<float>(view.rounds);
  for (LightAnswer& at : view.at) {
    at.irradiance *= share;
    at.deviation = share * glm::sqrt(at.deviation);
  }
  return view;
}

}  // namespace

ViewSurfaces surfacesOf(const LightTransport& transport, const SceneView& view, int width, int height, int thread_count) {
  SightOptions options;
  options.width = width;
  options.height = height;
  // one sample a pixel: each error belongs to one place
  options.samples_per_side = 1;
  options.balls = view.figure;
  options.thread_count = thread_count;
  ViewSurfaces surfaces;
  surfaces.sights = sightsOf(transport, view.camera, options);
  surfaces.classes.resize(surfaces.sights.samples.size());
  parallelFor(height, thread_count, [&](uint64_t row, int) {
    for (size_t i = row * width; i < (row + 1) * width; ++i) {
      const Sight& sight = surfaces.sights.samples[i];
      if (sight.kind != Sight::Kind::receiver) continue;
      // no surface's receiver stands exactly at the centre of a ball
      const bool is_on_figure = std::any_of(view.figure.begin(), view.figure.end(),
                                            [&](const Ball& ball) { return ball.centre_m == sight.receiver.position_m; });
      surfaces.classes[i] = classesOf(transport, sight.receiver, is_on_figure);
    }
  });
  return surfaces;
}

double medianNoise(const std::vector<LightAnswer>& truth) {
  std::vector<double> noise;
  for (const LightAnswer& at : truth) {
    const double light = luminanceOf(at.irradiance);
    if (light > 0.0) noise.push_back(luminanceOf(at.deviation) / light);
  }
  return medianOf(std::move(noise));
}

TracedView viewTruth(const LightTransport& transport, const Sights& sights, const ViewTruthOptions& options,
                     const std::string& path) {
  if (path.empty()) return traced(transport, sights, options);
  const std::string key = keyOf(sights, options);
  if (std::filesystem::exists(path)) {
    std::string why;
    TracedView view = readTruth(path, key, sights.samples.size(), &why);
    if (why.empty()) return view;
    std::cerr << path << ": " << why << "; traced anew\n";
  }
  TracedView view = traced(transport, sights, options);
  writeTruth(path, key, view);
  return view;
}

}  // namespace nlg
