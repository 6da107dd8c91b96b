#include "bake/prepared_scene.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "light/air.h"
#include "light/light_transport.h"
#include "light/probe_light.h"
#include "runtime_eval/probe_tree/probe_tree_data.h"
#include "scene/scene_size.h"
#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/parallel_for.h"
#include "tool/processor_time.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr double kWidestChosenM = 10.0;
constexpr double kMarginShare = 0.05;  // of a spacing: with so much air over a roof its cells find places in it (air_places.h)

// So many places at least in the whole scene: a grid of a few probes has few cells, and its light would be fitted to next to
// nothing.
constexpr uint64_t kFewestPlaces = 2048;

AirPlaceOptions airPlaceOptions(const BakeOptions& options, uint64_t cell_count) {
  AirPlaceOptions air;
  const auto for_all = static_cast<int>((kFewestPlaces + cell_count) / std::max<uint64_t>(1, cell_count));
  air.places_per_cell = std::max(options.light_samples, for_all);
  air.draws_per_cell = std::max(air.draws_per_cell, 4 * air.places_per_cell);
  air.seed = options.seed;
  return air;
}

std::string searchedSha256(const ProbeTree& tree, const SkyFaces& sky) {
  std::string bytes;
  const auto add = [&](const auto&... lists) {
    ((bytes += std::to_string(lists.size()) + ' ',
      bytes.append(reinterpret_cast<const char*>(lists.data()), lists.size() * sizeof(lists[0]))),
     ...);
  };
  const ProbeTreeData data = probeTreeData(tree);
  add(data.frame.first_m, data.frame.root_count, data.child_mask, data.used_mask, data.cell_count, sky.positions, sky.triangles);
  return sha256(bytes);
}

}  // namespace

SceneSource loadLitScene(const std::string& request, const BakeOptions& options) {
  // before minutes are spent on a word that is mistyped
  if (options.light != "none") lightWayFromName(options.light);
  directLightFromName(options.light_direct);
  const Progress progress("reading");
  SceneReading reading = options.reading;
  // without light, images serve geometry alone
  if (options.light == "none") reading.images = ImageNeed::geometry;
  SceneSource source = loadScene(request, reading);
  if (source.scene.triangles.empty()) throw InputError(request, "triangles", "at least one", "none");
  // before minutes are spent on a unit that is wrong
  if (!source.unit_question.empty())
    throw UsageError(fmt::format("{}: {}; --unit 1 keeps metres", request, source.unit_question));
  const auto isOpen = [](const Scene& scene) { return openShare(scene) > kOpenShare; };
  for (const std::string& done : applyLight(source.scene, options.scene_light, isOpen)) source.light_notes.push_back(done);
  return source;
}

PlacedScene::PlacedScene(SceneSource lit, const BakeOptions& options)
    : source(std::move(lit)), full_tree(place(options)), rays(source.scene) {}

ProbeTree PlacedScene::place(const BakeOptions& options) {
  const Progress progress("probe tree");
  const NearbyTriangles nearby(source.scene);
  ProbePlacementOptions placement;
  placement.density_growth = options.density_growth;
  placement.align_lattice = options.align_lattice;
  placement.max_probes = options.max_probes;
  placement.extent = extentFromNumbers(options.extent_m);
  placement.density = source.scene.density;
  const auto takeSpacing = [&](double finest_m) {
    placement.spacing_min_m = placement.spacing_max_m = finest_m;
    if (!placement.extent && !source.scene.extent) placement.reach = reachBeyondBounds(source.scene, kMarginShare * finest_m);
  };
  // to choose a spacing needs a placement: first with the one that is asked for, or the default
  takeSpacing(options.spacing_m > 0.0 ? options.spacing_m : BakeOptions().spacing_m);
  if (options.spacing_m == 0.0) {
    chosen = chooseSpacing(nearby, placement);
    // rooms of a few metres are lost in it: more likely a unit is
    if (chosen->spacing_m > kWidestChosenM && source.unit_m > 0.0 && options.reading.unit_m == 0.0) {
      throw UsageError(fmt::format(
          "{}: probes would be {:.3g} m apart; give --unit 0.01 if it was made in centimetres, --unit 1 if in metres, "
          "or --spacing-m",
          source.id, chosen->spacing_m));
    }
    takeSpacing(chosen->spacing_m);
  }
  spacing_m = static_cast<float>(placement.spacing_min_m);  // as the lattice has it
  extent = probeExtent(source.scene, placement);
  return placeProbes(nearby, placement, options.seed, &boxes);
}

PreparedScene::PreparedScene(const std::string& request, const BakeOptions& options)
    : PreparedScene(loadLitScene(request, options), options) {}

PreparedScene::PreparedScene(SceneSource lit, const BakeOptions& options, const KnownAir& known,
                             const std::function<void(const PlacedScene&)>& onPlaced)
    : PlacedScene(std::move(lit), options), searched_sha256(searchedSha256(full_tree, source.scene.light.sky_faces)) {
  if (onPlaced) onPlaced(*this);
  const auto start = std::chrono::steady_clock::now();
  AirPlaceOptions air_options = airPlaceOptions(options, full_tree.cellCount());
  // an earlier search of the same cells says which hold no air
  if (known.searched_sha256 == searched_sha256 && options.air_only) air_options.known = known.tree;
  air = findAirPlaces(rays, full_tree, air_options, threadsOf(options));
  air.spacing_m = spacing_m;
  tree = options.air_only ? treeOfAir(full_tree, air) : full_tree;
  air_wall_s = secondsSince(start);
}

ProbeTree PreparedScene::treeInWorld() const {
  ProbeTree moved = tree;
  const glm::dvec3& origin_m = source.scene.origin_m;
  moved.moveBy({origin_m.x, origin_m.y, origin_m.z});
  return moved;
}

}  // namespace nlg
