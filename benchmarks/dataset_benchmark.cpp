// Shards to disk and back on one core: functions/s and bytes a function. HDF5's own filters (deflate 1) stand beside.
//
// NLG_LEVELS names a folder of .glb levels, of which the first three are taken; a procedural level always is.

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "datagen/dataset/hdf5_file.h"
#include "datagen/dataset/shard_reader.h"
#include "datagen/shards/shard_job.h"
#include "tool/options.h"

namespace nlg {
namespace {

constexpr uint64_t kFunctionCount = 2048;

std::string scratchPath(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("nlg_bench_" + std::to_string(::getpid()) + name)).string();
}

// A shard of the scene's first functions.
Shard makeShard(const std::string& scene) {
  DatagenOptions options;
  OptionTable table("datagen");
  describe(options, table);
  const ShardJob job({scene, 1, false}, options, table);
  ShardCollector collector(job.header(), {kFunctionCount, 200000}, std::filesystem::temp_directory_path().string());
  const std::string path = scratchPath("_made.h5");
  ShardWriter writer(path, job.header());
  job.pipeline().run(2, collector, writer);
  ShardCounts counts = collector.counts();
  counts.grid_probes = job.probeCount();
  writer.finish(counts);
  Shard shard = readShard(path, 0);
  std::filesystem::remove(path);
  return shard;
}

void setCounters(benchmark::State& state, const Shard& shard, const std::string& path) {
  const auto count = static_cast<double>(shard.functionCount());
  state.counters["functions/s"] = benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes/function"] = static_cast<double>(std::filesystem::file_size(path)) / count;
  std::filesystem::remove(path);
}

void write(benchmark::State& state, const Shard& shard) {
  const std::string path = scratchPath("_write.h5");
  for (auto _ : state) writeShard(path, shard);
  setCounters(state, shard, path);
}

void writeByHdf5Filters(benchmark::State& state, const Shard& shard) {
  const std::string path = scratchPath("_filters.h5");
  const uint64_t N = shard.functionCount(), P = kSupportPointCount;
  for (auto _ : state) {
    Hdf5Writer file(path);
    file.write("phi", {N, P}, shard.phi.data());
    file.write("validity", {N, P / 8}, shard.validity.data());
    file.write("seen", {N, P / 8}, shard.seen.data());
    file.close();
  }
  setCounters(state, shard, path);
}

void read(benchmark::State& state, const Shard& shard) {
  const std::string path = scratchPath("_read.h5");
  writeShard(path, shard);
  for (auto _ : state) benchmark::DoNotOptimize(readShard(path, shard.pattern_hash).phi.data());
  setCounters(state, shard, path);
}

const bool kRegistered = [] {
  const auto add = [](const std::string& name, const std::string& scene) {
    const auto shard = [scene] {
      static std::map<std::string, Shard> made;
      if (made.count(scene) == 0) made[scene] = makeShard(scene);
      return &made[scene];
    };
    const auto bench = [&](const char* unit, void (*run)(benchmark::State&, const Shard&)) {
      benchmark::RegisterBenchmark((std::string("dataset/") + unit + "/" + name).c_str(), [shard, run](benchmark::State& state) {
        run(state, *shard());
      })->Unit(benchmark::kMillisecond);
    };
    bench("write", write);
    bench("write_by_hdf5_filters", writeByHdf5Filters);
    bench("read", read);
  };
  add("house_3", "house:3");
  const char* folder = std::getenv("NLG_LEVELS");
  if (folder == nullptr) return true;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".glb") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  paths.resize(std::min<size_t>(paths.size(), 3));
  for (const auto& path : paths) add(path.stem(), path.string());
  return true;
}();

}  // namespace
}  // namespace nlg
