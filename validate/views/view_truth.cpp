#include "validate/views/view_truth.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include <fmt/format.h>

#include "runtime_eval/numbers/random.h"
#include "runtime_eval/weights_file/tensor_file.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

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
  if (!result.ok() || irradiance.size() != 3 * samples || deviation.size() != 3 * samples || rounds.size() != 1) {
    *why = result.ok() ? "of another size" : result.detail;
    return {};
  }
  TracedView view;
  view.at.resize(samples);
  view.rounds = rounds.front();
  view.was_read = true;
  for (size_t i = 0; i < samples; ++i) {
    view.at[i].irradiance = {irradiance[3 * i], irradiance[3 * i + 1], irradiance[3 * i + 2]};
    view.at[i].deviation = {deviation[3 * i], deviation[3 * i + 1], deviation[3 * i + 2]};
  }
  return view;
}

void writeTruth(const std::string& path, const std::string& key, const TracedView& view) {
  std::vector<float> irradiance, deviation;
  for (const ReceivedLight& light : view.at) {
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
    return lightSamples(sights, truthLighting(transport, options.gather, mixSeed(options.seed, number)), options.thread_count);
  };
  TracedView view;
  view.at = round(0);
  const double over = medianNoise(view.at) / options.noise;
  view.rounds = static_cast<int>(std::clamp(std::ceil(over * over), 1.0, double{kMostTruthRounds}));
  for (ReceivedLight& at : view.at) at.deviation *= at.deviation;
  for (int number = 1; number < view.rounds; ++number) {
    const std::vector<ReceivedLight> more = round(number);
    for (size_t i = 0; i < more.size(); ++i) {
      view.at[i].irradiance += more[i].irradiance;
      view.at[i].deviation += more[i].deviation * more[i].deviation;
    }
  }
  const auto share = 1.0f / static_cast<float>(view.rounds);
  for (ReceivedLight& at : view.at) {
    at.irradiance *= share;
    at.deviation = share * glm::sqrt(at.deviation);
  }
  return view;
}

}  // namespace

double medianNoise(const std::vector<ReceivedLight>& truth) {
  std::vector<double> noise;
  for (const ReceivedLight& at : truth) {
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
