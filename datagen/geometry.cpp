#include "datagen/commands.h"
#include "datagen/shards/shard_scene.h"
#include "nlg/support.h"

namespace nlg {

nlohmann::ordered_json shardGeometry(const std::string& path, const std::string& scene_request, bool with_tree) {
  using Json = nlohmann::ordered_json;
  // all of it: what draws it reads it by other means, and leaves its checks to this
  const Shard shard = readShard(path, supportPattern().hash, kSupportPointCount);
  const std::string request = scene_request.empty() ? proceduralRequest(shard) : scene_request;
  if (request.empty()) return nullptr;
  const Scene scene = rebuildShardScene(shard, path, request);
  Json geometry{{"triangles_m", Json::array()}, {"double_sided", Json::array()}};
  for (size_t i = 0; i < scene.triangles.size(); ++i) {
    Json triangle = Json::array();
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 p = scene.origin_m + glm::dvec3(scene.positions[scene.triangles[i][corner]]);
      triangle.insert(triangle.end(), {p.x, p.y, p.z});
    }
    geometry["triangles_m"].push_back(std::move(triangle));
    geometry["double_sided"].push_back(scene.materials[scene.triangle_material[i]].double_sided);
  }
  if (!with_tree) return geometry;
  const ProbeTree tree = rebuildShardTree(shard, path, scene);
  const ProbeTreeFrame& frame = tree.frame();
  const glm::dvec3 first_m = scene.origin_m + glm::dvec3(frame.first_m[0], frame.first_m[1], frame.first_m[2]);
  const auto box = [&](const LatticePoint& low, int side) {
    const glm::dvec3 low_m = first_m + frame.spacing_m * glm::dvec3(low[0], low[1], low[2]);
    return Json{low_m.x, low_m.y, low_m.z, side * frame.spacing_m};
  };
  geometry["nodes"] = geometry["cells"] = Json::array();
  tree.forEachNode([&](const ProbeNode& node) {
    if (node.brick_side == 0) return;  // others hold no probe
    geometry["nodes"].push_back(box(node.low, node.side));
    geometry["nodes"].back().push_back(node.level);
  });
  tree.forEachCell([&](const ProbeCell& cell) { geometry["cells"].push_back(box(cell.low, cell.side)); });
  return geometry;
}

}  // namespace nlg
