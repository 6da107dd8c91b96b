#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "datagen/commands.h"
#include "datagen/shards/shard_scene.h"
#include "nlg/support.h"

namespace nlg {
namespace {

// The text of a JSON array. A tree of JSON values would be a hundred times as large, and its destructor allocates: where memory runs
// out there, no error can be told.
class ArrayText {
 public:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    if (text_.size() > 1) text_ += ',';
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }
  std::string text() const { return text_ + ']'; }

 private:
  std::string text_ = "[";
};

}  // namespace

std::string shardGeometry(const std::string& path, const std::string& scene_request, bool with_tree) {
  // all of it: what draws it reads it by other means, and leaves its checks to this
  const Shard shard = readShard(path, supportPattern().hash, kSupportPointCount);
  const std::string request = scene_request.empty() ? proceduralRequest(shard) : scene_request;
  if (request.empty()) return "null";
  const Scene scene = rebuildShardScene(shard, path, request);
  ArrayText triangles, double_sided;
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    ArrayText triangle;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 p = scene.origin_m + glm::dvec3(scene.positions[scene.triangles[i][corner]]);
      triangle.add("{},{},{}", p.x, p.y, p.z);
    }
    triangles.add("{}", triangle.text());
    double_sided.add("{}", scene.materials[scene.triangle_material[i]].double_sided);
  }
  const std::string surfaces = fmt::format(R"({{"triangles_m":{},"double_sided":{})", triangles.text(), double_sided.text());
  if (!with_tree) return surfaces + '}';
  const ProbeTree tree = rebuildShardTree(shard, path, scene);
  const ProbeTreeFrame& frame = tree.frame();
  const glm::dvec3 first_m = scene.origin_m + glm::dvec3(frame.first_m[0], frame.first_m[1], frame.first_m[2]);
  const auto box = [&](const LatticePoint& low, int side) {
    const glm::dvec3 low_m = first_m + frame.spacing_m * glm::dvec3(low[0], low[1], low[2]);
    return fmt::format("{},{},{},{}", low_m.x, low_m.y, low_m.z, side * frame.spacing_m);
  };
  ArrayText nodes, cells;
  tree.forEachNode([&](const ProbeNode& node) {
    // others hold no probe
    if (node.brick_side > 0) nodes.add("[{},{}]", box(node.low, node.side), node.level);
  });
  tree.forEachCell([&](const ProbeCell& cell) { cells.add("[{}]", box(cell.low, cell.side)); });
  return fmt::format(R"({},"nodes":{},"cells":{}}})", surfaces, nodes.text(), cells.text());
}

}  // namespace nlg
