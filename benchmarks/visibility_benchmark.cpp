// Visibility (validity included) and diffusion over all kinds of probes of a level's tree, one core and two, beside plain Embree.
//
// NLG_LEVELS names a folder of .glb levels; without it two procedural levels stand in.

#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>

#include "datagen/probes/probe_placement.h"
#include "datagen/probes/shuffled_order.h"
#include "datagen/weighting/weighting_builder.h"
#include "scene/gltf_reader.h"
#include "scene/procedural.h"

namespace nlg {
namespace {

constexpr int kProbeCount = 2000;  // an iteration: a fair sample of the level's probes
constexpr double kSpacing = 1.5;   // metres, the finest

using Clock = std::chrono::steady_clock;

struct Place {
  glm::dvec3 position_m;
  float spacing_m;
};

struct Level {
  explicit Level(const Scene& scene) : rays(scene), links(makeLinkTable({})) {
    const ProbeTree tree = placeProbes(scene, {.spacing_min_m = kSpacing, .spacing_max_m = kSpacing}, 1);
    ShuffledOrder order(tree.probeCount(), 1);
    for (uint64_t index = 0; places.size() < kProbeCount && order.next(&index);) {
      const PositionM at = tree.probePosition(index);
      places.push_back({{at[0], at[1], at[2]}, tree.probeSpacing(index)});
    }
  }
  RayScene rays;
  LinkTable links;
  std::vector<Place> places;
};

benchmark::Counter rate(double count) { return {count, benchmark::Counter::kIsRate}; }

// Traces segments of the support, from the probe when `from` is null; returns how many are blocked.
uint32_t traceByEmbree(const RayScene& rays, const Place& place, const std::array<AlignedFloats, 3>* from,
                       const std::array<AlignedFloats, 3>& to) {
  uint32_t blocked = 0;
  for (size_t first = 0; first < to[0].size(); first += kPacketSize) {
    SegmentPacket packet;
    float* origin[3] = {packet.origin_x, packet.origin_y, packet.origin_z};
    float* direction[3] = {packet.direction_x, packet.direction_y, packet.direction_z};
    for (int axis = 0; axis < 3; ++axis) {
      const auto center = static_cast<float>(place.position_m[axis]);
      for (size_t i = 0; i < kPacketSize; ++i) {
        const float begin = from == nullptr ? 0.0f : (*from)[axis][first + i];
        origin[axis][i] = center + place.spacing_m * begin;
        direction[axis][i] = place.spacing_m * (to[axis][first + i] - begin);
      }
    }
    blocked += static_cast<uint32_t>(__builtin_popcount(rays.occluded(packet, kPacketSize)));
  }
  return blocked;
}

// Each thread takes every other probe.
void visibility(benchmark::State& state, const Level& level) {
  WeightingBuilder builder(level.rays, level.links, {});
  double probes = 0.0, functions = 0.0;
  for (auto _ : state) {
    for (size_t i = static_cast<size_t>(state.thread_index()); i < level.places.size();
         i += static_cast<size_t>(state.threads())) {
      functions += builder.see(level.places[i].position_m, level.places[i].spacing_m) == ProbeOutcome::function;
      probes += 1.0;
    }
  }
  state.counters["probes/s"] = rate(probes);
  state.counters["functions/s"] = rate(functions);
  if (state.thread_index() == 0) {
    state.counters["rays/function"] = static_cast<double>(builder.visibility().rayCount()) / functions;
    state.counters["packet_tests/function"] = static_cast<double>(builder.visibility().packetTestCount()) / functions;
  }
}

// The peer: the same visibility of the probes that have a function, its rays and all links traced by Embree's packets of 16.
void embreeAllLinks(benchmark::State& state, const Level& level) {
  std::vector<Place> places;
  WeightingBuilder builder(level.rays, level.links, {});
  for (const Place& place : level.places) {
    if (places.size() < 50 && builder.see(place.position_m, place.spacing_m) == ProbeOutcome::function) places.push_back(place);
  }
  SupportVisibility visibility(level.rays, level.links);
  double functions = 0.0;
  for (auto _ : state) {
    Clock::duration spent{0};
    for (const Place& place : places) {
      visibility.beginProbe(place.position_m, place.spacing_m);
      visibility.traceProbeRays();
      visibility.testLinks();
      const Clock::time_point begin = Clock::now();
      visibility.probeVote();
      benchmark::DoNotOptimize(traceByEmbree(level.rays, place, nullptr, level.links.point_packets.at));
      benchmark::DoNotOptimize(traceByEmbree(level.rays, place, &level.links.link_packets.from, level.links.link_packets.to));
      visibility.findValidity();
      spent += Clock::now() - begin;
      functions += 1.0;
    }
    state.SetIterationTime(std::chrono::duration<double>(spent).count());
  }
  state.counters["functions/s"] = rate(functions);
}

enum class Part { visibility, diffusion };

// Of the probes that have a function, timed function by function.
void ofFunctions(benchmark::State& state, const Level& level, Part part) {
  WeightingBuilder builder(level.rays, level.links, {});
  GeneratedFunction function;
  double functions = 0.0;
  for (auto _ : state) {
    Clock::duration spent{0};
    for (const Place& place : level.places) {
      const Clock::time_point begin = Clock::now();
      if (builder.see(place.position_m, place.spacing_m) != ProbeOutcome::function) continue;
      const Clock::time_point seen = Clock::now();
      builder.generate(&function);
      const Clock::time_point end = Clock::now();
      spent += part == Part::visibility ? seen - begin : end - seen;
      functions += 1.0;
    }
    state.SetIterationTime(std::chrono::duration<double>(spent).count());
  }
  state.counters["functions/s"] = rate(functions);
}

const bool kRegistered = [] {
  // a level is prepared when its first case runs
  const auto add = [](const std::string& name, const std::function<Scene()>& load) {
    const auto level = std::make_shared<std::unique_ptr<Level>>();
    const auto prepared = [load, level]() -> const Level& {
      if (!*level) *level = std::make_unique<Level>(load());
      return **level;
    };
    const auto at = [&](const char* unit) { return std::string(unit) + "/" + name; };
    benchmark::RegisterBenchmark(at("visibility/functions").c_str(),
                                 [prepared](benchmark::State& state) { ofFunctions(state, prepared(), Part::visibility); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(at("visibility/embree_all_links").c_str(),
                                 [prepared](benchmark::State& state) { embreeAllLinks(state, prepared()); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(at("visibility/all_probes").c_str(),
                                 [prepared](benchmark::State& state) { visibility(state, prepared()); })
        ->Threads(1)
        ->Threads(2)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(at("weighting/diffusion").c_str(),
                                 [prepared](benchmark::State& state) { ofFunctions(state, prepared(), Part::diffusion); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  };
  add("house_3", [] { return makeProceduralScene("house", 3); });
  add("cave_2", [] { return makeProceduralScene("cave", 2); });
  const char* folder = std::getenv("NLG_LEVELS");
  if (folder == nullptr) return true;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".glb") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) add(path.stem(), [path] { return readGltf(path).scene; });
  return true;
}();

}  // namespace
}  // namespace nlg
