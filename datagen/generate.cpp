#include "datagen/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/printable.h"
#include "tool/progress.h"

namespace nlg {
namespace {

// How much of the way to its limits a shard has come, 0 … 1.
double shareDone(const ShardCounts& counts, const CollectorLimits& limits) {
  const auto share = [](uint64_t done, uint64_t all) {
    return static_cast<double>(done) / static_cast<double>(std::max<uint64_t>(all, 1));
  };
  return std::min(1.0, std::max(share(counts.functions, limits.functions), share(counts.visited_probes, limits.visited_probes)));
}

// What a disk that refused would have needed, and what it has.
std::string spaceText(const std::string& out, const FunctionCollector& collector, const ShardWriter& writer,
                      const CollectorLimits& limits) {
  const double share = shareDone(collector.counts(), limits);
  const auto megabytes = [](double bytes) { return fmt::format("{:.1f} MB", bytes / 1e6); };
  const auto so_far = static_cast<double>(writer.byteCount()), rows = static_cast<double>(collector.spooledBytes());
  std::error_code error;
  const auto space = std::filesystem::space(std::filesystem::absolute(out).parent_path(), error);
  std::string text = fmt::format("{} {} done, {:.1f} % of the shard", countText(writer.functionCount(), "function"),
                                 writer.functionCount() == 1 ? "was" : "were", 100.0 * share);
  if (share > 0.0 && so_far > 0.0) {
    text += fmt::format("; it needs about {} and {} more while it is made", megabytes(so_far / share), megabytes(rows / share));
  } else {
    text += fmt::format("; it needs up to {} more while it is made",
                        megabytes(static_cast<double>(limits.functions) * kSupportPointCount * 9 / 8));
  }
  return text + (error ? "" : fmt::format("; {} are free", megabytes(static_cast<double>(space.available))));
}

// The system's words of an OutputError, without the name of a temporary file.
std::string reasonOf(const OutputError& error) {
  const std::string text = error.what(), mark = ": cannot be written: ";
  const size_t at = text.find(mark);
  return at == std::string::npos ? text : text.substr(at + mark.size());
}

void report(Progress& progress, const FunctionCollector& collector, const CollectorLimits& limits) {
  if (!progress.due()) return;
  const ShardCounts& counts = collector.counts();
  // the limit on functions may come long before the last probe
  const double share = shareDone(counts, limits);
  if (share > 0.0) progress.setTotal(static_cast<int64_t>(std::lround(static_cast<double>(counts.visited_probes) / share)));
  progress.update(static_cast<int64_t>(counts.visited_probes), countText(counts.functions, "function"));
}

nlohmann::ordered_json resultJson(const ShardJob& job, const FunctionCollector& collector, uint64_t file_bytes) {
  ShardCounts counts = collector.counts();
  counts.grid_probes = job.probeCount();
  nlohmann::ordered_json json = {{"scene", job.header().scene_id}, {"jitter", job.header().jitter}};
  json.update(countsJson(counts));
  json.update({{"bytes", file_bytes}, {"dropped_triangles", job.scene().dropped_triangle_count}});
  return json;
}

void warn(const ShardJob& job, const ShardCounts& counts) {
  const std::string& scene = job.header().scene_id;
  if (job.scene().triangles.empty())
    std::cerr << "nlg-datagen: " << scene << ": the scene has no triangle; the shard is empty\n";
  else if (counts.functions == 0)
    std::cerr << "nlg-datagen: " << scene << ": no probe has a weighting function; the shard is empty\n";
  if (counts.visited_probes < job.probeCount() && counts.functions < job.limits().functions) {
    std::cerr << "nlg-datagen: " << scene << ": stopped after " << counts.visited_probes << " of " << job.probeCount()
              << " probes (max_visited_probes)\n";
  }
}

}  // namespace

void generate(const ShardRequest& request, const std::string& out, const DatagenOptions& options, const OptionTable& table) {
  const ShardJob job(request, options, table);
  const CollectorLimits limits = job.limits();
  nlohmann::ordered_json result;
  // the shard replaces an older one only when it is whole: a run that ends early leaves no half file
  writeAtomically(out, [&](const std::string& temporary_path) {
    ShardWriter writer(temporary_path, job.header());
    FunctionCollector collector = job.collector(limits, std::filesystem::absolute(out).parent_path().string());
    Progress progress("probes", static_cast<int64_t>(limits.visited_probes));
    FunctionPipeline pipeline = job.pipeline();
    pipeline.report = [&](const FunctionCollector& at_work) { report(progress, at_work, limits); };
    try {
      // threads compress chunks, which are appended in order: the bytes do not depend on threads
      pipeline.makeFinisher = appendTo(writer);
      pipeline.run(options.threads, collector);
      ShardCounts counts = collector.counts();
      counts.grid_probes = job.probeCount();
      writer.finish(counts);
    } catch (const OutputError& error) {
      // HDF5's own words say neither that the disk is full nor how much the rest needs
      throw OutputError(out, reasonOf(error) + "; " + spaceText(out, collector, writer, limits));
    }
    warn(job, collector.counts());
    result = resultJson(job, collector, std::filesystem::file_size(temporary_path));
  });
  std::cout << result.dump() << '\n';
}

}  // namespace nlg
