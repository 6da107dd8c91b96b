#include "validate/views/scene_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "render/lit_picture.h"
#include "render/tone.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "validate/light/light_places.h"
#include "validate/light/rooms.h"
#include "validate/views/view_figures.h"

namespace nlg {
namespace {

constexpr uint64_t kPlaceStream = 0x7669657773, kLitStream = 0x6c6974;
constexpr uint64_t kDrawnPerPlace = 8;                   // places in air that rooms are made of are chosen among
constexpr size_t kSpotsPerRoom = 64, kEyesPerView = 10;  // that are judged
constexpr double kFigureNearM = 1.5, kFigureFarM = 8.0;  // from the eye

constexpr int kLitWidth = 16, kLitHeight = 9, kLitRays = 16;  // by which a view's light is estimated
constexpr double kLitFarM = 10.0;  // what is further away counts as if it were here: no view is all horizon

// What a view shows of surfaces, before it is known what is lit.
struct ShownSurface {
  double light = 0.0;    // luminance of irradiance
  double area_m2 = 0.0;  // that faces the eye
};

struct Candidate {
  SceneView view;
  std::vector<ShownSurface> shown;
  double median = 0.0;  // light, of what is not black
  double lit_m2 = 0.0;
};

// A room with a floor.
struct Standing {
  uint32_t room = 0;
  bool has_roof = false;
  std::vector<Spot> spots;
  std::vector<Candidate> views = {};  // those that show most lit surface first
  bool is_dark = true;

  // Lit rooms under a roof, lit ones outdoors, dark ones.
  int rank() const { return 2 * is_dark + !has_roof; }
};

// Those with a wide floor; of a room that has none, all. A room that lies mostly under a roof has none before its windows.
// spots   by place
Standing standingIn(const std::vector<SeenRoom>& rooms, uint32_t room, const std::vector<std::optional<Spot>>& spots) {
  std::array<std::vector<Spot>, 2> wide, all;  // without and with a roof
  for (const uint32_t place : rooms[room].places) {
    const std::optional<Spot>& spot = spots[place];
    if (!spot) continue;
    all[spot->has_roof].push_back(*spot);
    if (spot->is_wide) wide[spot->has_roof].push_back(*spot);
  }
  Standing standing{room, all[1].size() > all[0].size(), {}};
  const bool roof = standing.has_roof;
  standing.spots = std::move(wide[roof].empty() ? all[roof] : wide[roof]);
  if (standing.spots.size() > kSpotsPerRoom) standing.spots.resize(kSpotsPerRoom);
  return standing;
}

// In turn, so that no room has another view before each has one: lit rooms under a roof, of which the largest get one more, then lit
// ones outdoors, then dark ones.
// standing   by rank
std::vector<size_t> viewCounts(const std::vector<Standing>& standing, const SceneViewOptions& options) {
  std::vector<size_t> counts(standing.size(), 0);
  auto left = static_cast<size_t>(options.most_views);
  const auto giveEach = [&](size_t begin, size_t end) {
    for (size_t s = begin; s < end && left > 0; ++s, --left) ++counts[s];
  };
  const auto countTo = [&](int rank) {
    return static_cast<size_t>(std::count_if(standing.begin(), standing.end(), [&](const auto& s) { return s.rank() <= rank; }));
  };
  const size_t roofed = countTo(0), lit = countTo(1);
  for (int round = 0; round < options.views_per_room; ++round) giveEach(0, roofed);
  giveEach(0, std::min(roofed, kLargestRooms));
  for (int round = 0; round < options.views_per_room; ++round) giveEach(roofed, lit);
  for (int round = 0; round < options.views_per_room; ++round) giveEach(lit, standing.size());
  return counts;
}

// Groups of spots, far from one another: the first lies around the room's middle, each of the others where most is left.
std::vector<std::vector<Spot>> apart(const std::vector<Spot>& spots, const glm::dvec3& middle_m, size_t count) {
  const auto distanceTo = [&](const Spot& spot, const glm::dvec3& place) { return glm::distance(spot.eye_m, place); };
  std::vector<glm::dvec3> seeds = {std::min_element(spots.begin(), spots.end(), [&](const Spot& a, const Spot& b) {
                                     return distanceTo(a, middle_m) < distanceTo(b, middle_m);
                                   })->eye_m};
  const auto nearest = [&](const Spot& spot) {
    return std::min_element(seeds.begin(), seeds.end(),
                            [&](const glm::dvec3& a, const glm::dvec3& b) { return distanceTo(spot, a) < distanceTo(spot, b); });
  };
  while (seeds.size() < std::min(count, spots.size())) {
    const auto furthest = std::max_element(spots.begin(), spots.end(), [&](const Spot& a, const Spot& b) {
      return distanceTo(a, *nearest(a)) < distanceTo(b, *nearest(b));
    });
    seeds.push_back(furthest->eye_m);
  }
  std::vector<std::vector<Spot>> groups(seeds.size());
  for (const Spot& spot : spots) groups[nearest(spot) - seeds.begin()].push_back(spot);
  return groups;
}

// Whether a figure can stand there, and is seen from head to foot.
bool fits(const Spot& spot, const Camera& camera, double aspect, const Spots& spots) {
  const double away = glm::distance(spot.eye_m, camera.eye_m);
  if (!spot.is_upright || away < kFigureNearM || away > kFigureFarM) return false;
  for (const double height_m : {0.0, kFigureHeightM}) {
    const std::optional<glm::dvec2> at = camera.seenAt(spot.floor_m + glm::dvec3(0.0, height_m, 0.0), aspect);
    if (!at || at->x < 0.1 || at->x > 0.9 || at->y < 0.0 || at->y > 1.0) return false;
  }
  for (const FigureBall& ball : kFigure) {
    if (spots.isBlocked(camera.eye_m, spot.floor_m + glm::dvec3(0.0, ball.height_m, 0.0))) return false;
  }
  return true;
}

// Where the view shows it, as near to the room's middle as may be.
std::vector<Ball> figureIn(const Camera& camera, double aspect, const SeenRoom& room, std::vector<Spot> candidates,
                           const Spots& spots) {
  // of small rooms few spots are known: some straight before the eye
  for (const double away_m : {2.2, 2.6, 3.0, 4.0}) {
    for (const double aside : {0.0, -0.3, 0.3}) {
      const glm::vec3 along = camera.direction(0.5 + aside, 0.5, aspect);
      const glm::dvec3 place = camera.eye_m + away_m * glm::normalize(glm::dvec3(along.x, 0.0, along.z));
      if (spots.isBlocked(camera.eye_m, place)) continue;
      if (const std::optional<Spot> spot = spots.below(place)) candidates.push_back(*spot);
    }
  }
  const Spot* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Spot& spot : candidates) {
    const double away = glm::distance(spot.eye_m, room.middle_m);
    if (away < least && fits(spot, camera, aspect, spots)) least = away, best = &spot;
  }
  std::vector<Ball> figure;
  if (best == nullptr) return figure;
  for (const FigureBall& ball : kFigure) figure.push_back({best->floor_m + glm::dvec3(0.0, ball.height_m, 0.0), ball.radius_m});
  return figure;
}

// From one part of the room.
SceneView viewFrom(const std::vector<Spot>& group, const Standing& standing, const SeenRoom& room, const Spots& spots,
                   const LightTransport& transport, const SceneViewOptions& options) {
  const double aspect = static_cast<double>(options.width) / options.height;
  std::vector<glm::dvec3> eyes;
  for (size_t i = 0; i < std::min(kEyesPerView, group.size()); ++i) eyes.push_back(group[i].eye_m);
  SceneView view;
  view.has_roof = standing.has_roof;
  view.camera = bestView(transport, eyes, options.fov_y, aspect);
  view.figure = figureIn(view.camera, aspect, room, standing.spots, spots);
  // from another place, if from there a figure is seen
  for (size_t i = 0; i < eyes.size() && view.figure.empty(); ++i) {
    const Camera camera = bestView(transport, {eyes[i]}, options.fov_y, aspect);
    view.figure = figureIn(camera, aspect, room, standing.spots, spots);
    if (!view.figure.empty()) view.camera = camera;
  }
  return view;
}

Candidate judged(SceneView view, const LightTransport& transport, uint64_t seed) {
  Candidate candidate{std::move(view), {}};
  const Camera& camera = candidate.view.camera;
  SightOptions options;
  options.width = kLitWidth;
  options.height = kLitHeight;
  options.samples_per_side = 1;
  const Sights sights = sightsOf(transport, camera, options);
  GatherOptions gather;
  gather.rays = kLitRays;
  const std::vector<LightAnswer> light = lightSamples(sights, trueLight(transport, gather, seed), 1);
  const double pixel = 2.0 * std::tan(0.5 * camera.fov_y) / kLitHeight;
  for (size_t i = 0; i < light.size(); ++i) {
    if (sights.samples[i].kind != Sight::Kind::receiver) continue;
    const double depth = glm::dot(sights.samples[i].receiver.position_m - camera.eye_m, glm::dvec3(camera.forward));
    const double side = pixel * std::min(depth, kLitFarM);
    candidate.shown.push_back({luminanceOf(light[i].irradiance), side * side});
  }
  candidate.median = medianLight(sights, light);
  return candidate;
}

// Orders each room's views and the rooms by what of them is lit.
void orderByLight(double least_light, std::vector<Standing>* standing) {
  for (const Standing& room : *standing) {
    for (const Candidate& candidate : room.views) least_light = std::max(least_light, kLeastLight * candidate.median);
  }
  const auto byLitArea = [](const Candidate& a, const Candidate& b) { return a.lit_m2 > b.lit_m2; };
  for (Standing& room : *standing) {
    for (Candidate& candidate : room.views) {
      double all_m2 = 0.0;
      for (const ShownSurface& surface : candidate.shown) {
        all_m2 += surface.area_m2;
        if (surface.light > least_light) candidate.lit_m2 += surface.area_m2;
      }
      if (candidate.lit_m2 > kLeastLitShare * all_m2) room.is_dark = false;
    }
    std::stable_sort(room.views.begin(), room.views.end(), byLitArea);
  }
  std::stable_sort(standing->begin(), standing->end(), [&](const Standing& a, const Standing& b) {
    return a.rank() != b.rank() ? a.rank() < b.rank() : byLitArea(a.views.front(), b.views.front());
  });
}

// Half of them or more lie under a roof where there are so many: in the open a house's rooms would be a handful of places each.
std::vector<glm::dvec3> placesInAir(const LightTransport& transport, const ExtentBox& extent, const SceneViewOptions& options) {
  LightPlaceOptions place_options;
  place_options.air = kDrawnPerPlace * options.places_in_air;
  place_options.surface = place_options.walks = place_options.edges = 0;
  place_options.source_distance_m = 0.0;
  place_options.seed = mixSeed(options.seed, kPlaceStream);
  std::vector<glm::dvec3> places, open;
  for (const LightPlace& place : drawLightPlaces(transport.scene(), transport.rays(), extent, place_options).places) {
    const LightHit above = transport.rays().lightHit(glm::vec3(place.position_m), {0.0f, 1.0f, 0.0f});
    (above.kind == LightHit::Kind::surface ? places : open).push_back(place.position_m);
  }
  const size_t count = std::min<size_t>(options.places_in_air, places.size() + open.size());
  const size_t open_count = std::min(open.size(), std::max(count / 2, count - std::min(count, places.size())));
  places.resize(count - open_count);
  places.insert(places.end(), open.begin(), open.begin() + static_cast<ptrdiff_t>(open_count));
  return places;
}

}  // namespace

SceneViews findViews(const LightTransport& transport, const ExtentBox& extent, const SceneViewOptions& options) {
  const RayScene& rays = transport.rays();
  // rooms by sight, from geometry alone: views do not depend on a bake
  const std::vector<glm::dvec3> places = placesInAir(transport, extent, options);
  RoomOptions room_options;
  room_options.threads = options.thread_count;
  const std::vector<SeenRoom> rooms = findRooms(rays, places, room_options);
  SceneViews found;
  found.rooms = static_cast<uint32_t>(rooms.size());
  const Spots spots(transport, extent);

  // a spot to stand on below each place
  std::vector<std::optional<Spot>> spot_of(places.size());
  parallelFor(places.size(), options.thread_count, [&](uint64_t p, int) { spot_of[p] = spots.below(places[p]); });
  // hollows of walls and the air over ceilings are nobody's, unless the whole scene is as low
  const bool is_high = std::any_of(spot_of.begin(), spot_of.end(), [](const auto& spot) { return spot && spot->is_upright; });
  for (std::optional<Spot>& spot : spot_of) {
    if (is_high && spot && !spot->is_upright) spot.reset();
  }
  std::vector<Standing> standing;
  for (uint32_t r = 0; r < rooms.size(); ++r) {
    standing.push_back(standingIn(rooms, r, spot_of));
    if (standing.back().spots.empty()) standing.pop_back();
  }
  found.rooms_without_floor = found.rooms - static_cast<uint32_t>(standing.size());

  // eyes of a view stand in one part of the room; views are spread over it, one more than most rooms get
  const auto most = static_cast<size_t>(std::min(options.views_per_room + 1, options.most_views));
  std::vector<std::pair<Standing*, std::vector<Spot>>> parts;
  for (Standing& room : standing) {
    for (std::vector<Spot>& group : apart(room.spots, rooms[room.room].middle_m, most))
      parts.emplace_back(&room, std::move(group));
  }
  std::vector<Candidate> candidates(parts.size());
  parallelFor(parts.size(), options.thread_count, [&](uint64_t c, int) {
    const auto& [room, group] = parts[c];
    candidates[c] = judged(viewFrom(group, *room, rooms[room->room], spots, transport, options), transport,
                           mixSeed(options.seed, kLitStream, c));
  });
  for (size_t c = 0; c < parts.size(); ++c) parts[c].first->views.push_back(std::move(candidates[c]));

  // indoors is where grids leak, but a room without light shows nothing of it
  orderByLight(leastAdapted(transport.scene()), &standing);
  const std::vector<size_t> counts = viewCounts(standing, options);
  found.rooms_left_out = static_cast<uint32_t>(std::count(counts.begin(), counts.end(), 0));
  for (size_t s = 0; s < standing.size(); ++s) {
    found.rooms_dark += standing[s].is_dark;
    for (size_t v = 0; v < std::min(counts[s], standing[s].views.size()); ++v) {
      found.views.push_back(std::move(standing[s].views[v].view));
      found.views.back().room = static_cast<uint32_t>(s);
    }
  }
  return found;
}

SceneViews cameraViews(const LightTransport& transport) {
  SceneViews found;
  for (const Viewpoint& viewpoint : transport.scene().viewpoints) {
    if (!(viewpoint.fov_y > 0.0f)) continue;  // a place
    const glm::dvec3 eye(viewpoint.position);
    const bool has_roof = transport.rays().lightHit(glm::vec3(eye), {0.0f, 1.0f, 0.0f}).kind == LightHit::Kind::surface;
    found.views.push_back({found.rooms++, {eye, viewpoint.forward, viewpoint.up, viewpoint.fov_y}, {}, has_roof});
  }
  return found;
}

}  // namespace nlg
