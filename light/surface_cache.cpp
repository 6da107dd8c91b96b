#include "light/surface_cache.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr uint64_t kBlock = 64, kDiscoveryBlock = 512;
constexpr size_t kParts = 128;  // that the cells are put together in, by ranges of their keys
constexpr int kCoordinateBits = 20;
constexpr uint64_t kCubeBits = (uint64_t{1} << 3 * kCoordinateBits) - 1;  // of a key: without its side
constexpr int kLampGrid = 8;                                              // points a side of a cell beside a lamp
constexpr uint64_t kDiscoveryStream = 0x646973, kCellStream = 0x63656c6c, kRestStream = 0x72657374, kPointStream = 0x706f696e74;
constexpr int kLeastRays = 8;  // of a point that gathers
constexpr int kMostIterations = 64;
constexpr float kSettled = 1e-4f;      // of the largest irradiance: a change that ends the exchange
constexpr float kMarginShare = 0.05f;  // of a cell: how far beyond the points that were found it holds
constexpr double kFewestHits = 0.5;    // of a cell, by all rays of all places: measuring it takes as long as some paths
constexpr float kReflectanceStep =
    0x1p-13f;  // up to 8: what is scattered back by a transmissive surface, as a path takes it, may be beyond 1
constexpr float kOffset =
    0.3717f;  // of the cubes, in cells: walls like to stand on whole numbers, and would fall into two by their last bits
// Of a cell: how far off the surface rays between its points are. At the surface, and over a door's gap.
constexpr std::array<float, 2> kLiftShares = {0.05f, 0.4f};

// 0 … 5: the axis that a normal is nearest to, and its sign.
uint64_t sideOf(const glm::vec3& normal) {
  const glm::vec3 size = glm::abs(normal);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return static_cast<uint64_t>(2 * axis + (normal[axis] < 0.0f));
}

// The two axes across the one that a normal is nearest to.
std::array<int, 2> acrossAxes(const glm::vec3& normal) {
  const auto facing = static_cast<int>(sideOf(normal) / 2);
  return {(facing + 1) % 3, (facing + 2) % 3};
}

uint64_t blockCount(size_t count, uint64_t size = kBlock) { return (count + size - 1) / size; }

// Calls visit(first, end) for the points of every cell, which stand together.
template <class Point, class Visit>
void forEachCell(const std::vector<Point>& points, const Visit& visit) {
  for (size_t first = 0; first < points.size();) {
    size_t end = first + 1;
    while (end < points.size() && points[end].key == points[first].key) ++end;
    visit(first, end);
    first = end;
  }
}

// Whether a wall or a door stands between two points of a surface.
bool standsBetween(const RayScene& rays, float cell_m, const glm::vec3& a, const glm::vec3& normal_a, const glm::vec3& b,
                   const glm::vec3& normal_b) {
  return std::any_of(kLiftShares.begin(), kLiftShares.end(), [&](float share) {
    return rays.isBlocked(a + normal_a * (share * cell_m), b + normal_b * (share * cell_m));
  });
}

float largest(const glm::vec3& rgb) { return std::max({rgb.r, rgb.g, rgb.b}); }

}  // namespace

SurfaceCache::SurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                           const SurfaceCacheOptions& options, int thread_count)
    : cells_per_m_(1.0f / options.cell_m), group_count_(transport.groupCount()) {
  findCells(transport, places, options, thread_count);
  findWholeCells(transport, thread_count);
  buildTable();
  measure(transport, options, thread_count);
  const Progress progress("bounces between surfaces");
  irradiance_ = direct_;
  for (size_t group = 0; group < group_count_; ++group) exchange(group, thread_count);
  links_ = {};
  points_ = {};
  is_whole_ = {};
}

SurfaceCache::Spot SurfaceCache::spotOf(const glm::vec3& point, const glm::vec3& normal) const {
  const glm::vec3 at = point * cells_per_m_ + kOffset, low = glm::floor(at);
  Spot spot{sideOf(normal), {}};
  for (int axis = 0; axis < 3; ++axis) {
    const auto cube = static_cast<int64_t>(low[axis]) + (1 << (kCoordinateBits - 1));
    spot.key = spot.key << kCoordinateBits | (static_cast<uint64_t>(cube) & ((1u << kCoordinateBits) - 1));
  }
  const std::array<int, 2> axes = acrossAxes(normal);
  for (size_t a = 0; a < 2; ++a) spot.across[a] = static_cast<uint8_t>((at[axes[a]] - low[axes[a]]) * 255.0f);
  return spot;
}

// Of every cell's points those that lie furthest out along the two axes across the way it faces: a wall that divides the cell
// stands between some of them, and what lies further out still may be behind a wall that none of them told of. By rising keys.
std::vector<SurfaceCache::Found> SurfaceCache::outermost(std::vector<Found> found) const {
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.key < b.key; });
  std::vector<Found> kept;
  forEachCell(found, [&](size_t first, size_t end) {
    std::array<const Found*, kPointsPerCell> of_cell{};
    size_t count = 0;
    for (const int axis : acrossAxes(found[first].normal)) {
      const auto [low, high] = std::minmax_element(found.data() + first, found.data() + end, [&](const Found& x, const Found& y) {
        return x.position[axis] < y.position[axis];
      });
      for (const Found* point : {low, high}) {
        if (std::find(of_cell.begin(), of_cell.begin() + count, point) == of_cell.begin() + count) of_cell[count++] = point;
      }
    }
    for (size_t k = 0; k < count; ++k) kept.push_back(*of_cell[k]);
  });
  return kept;
}

void SurfaceCache::findCells(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                             const SurfaceCacheOptions& options, int thread_count) {
  Progress progress("sample points that look for surfaces", static_cast<int64_t>(places.size()));
  std::vector<std::vector<Found>> blocks(blockCount(places.size(), kDiscoveryBlock));
  parallelForBlocks(places.size(), kDiscoveryBlock, thread_count, [&](uint64_t first, uint64_t end, int) {
    std::vector<Found> found;
    for (size_t i = first; i < end; ++i) {
      const glm::vec3 from(places[i]);
      const Lattice lattice(mixSeed(options.seed, kDiscoveryStream), i);
      for (int ray = 0; ray < options.discovery_rays; ++ray) {
        const auto [u, v] = lattice.point(ray, options.discovery_rays);
        const glm::vec3 direction = sphereDirection(u, v);
        const auto find = [&](const LightHit& hit) {
          // surfaces further off are met by too few rays to be worth a cell
          if (hit.distance > options.reach_m) return;
          const glm::vec3 point = from + direction * hit.distance;
          found.push_back({spotOf(point, hit.normal).key, point, hit.normal});
        };
        const LightHit hit = transport.rays().lightHit(from, direction);
        if (hit.kind == LightHit::Kind::surface) find(hit);
        // transmissive surfaces on the way scatter light, too
        const float reach = hit.kind == LightHit::Kind::nothing ? INFINITY : hit.distance;
        LightHit pane = transport.rays().transmissiveHit(from, direction, 0.0f, reach);
        for (; pane.kind == LightHit::Kind::surface;
             pane = transport.rays().transmissiveHit(from, direction, RayScene::justBehind(pane), reach))
          find(pane);
      }
    }
    // a block keeps the outermost points of its cells alone
    blocks[first / kDiscoveryBlock] = outermost(std::move(found));
    progress.advance(static_cast<int64_t>(end - first));
  });
  addCells(transport, blocks, thread_count);
}

// blocks   each by rising keys: put together range by range of the keys, every range by one thread
void SurfaceCache::addCells(const LightTransport& transport, const std::vector<std::vector<Found>>& blocks, int thread_count) {
  // ranges of about as many points each, by a sample of the keys
  std::vector<uint64_t> sample;
  for (const std::vector<Found>& block : blocks) {
    for (size_t i = 0; i < block.size(); i += kBlock) sample.push_back(block[i].key);
  }
  std::sort(sample.begin(), sample.end());
  const auto firstKey = [&](size_t part) { return part == 0 ? 0 : sample[part * sample.size() / kParts]; };
  const auto isBefore = [](const Found& point, uint64_t key) { return point.key < key; };
  std::vector<std::vector<Found>> parts(sample.empty() ? 0 : kParts);
  std::vector<size_t> divided(parts.size(), 0);
  const float cell_m = 1.0f / cells_per_m_;
  parallelFor(parts.size(), thread_count, [&](uint64_t part, int) {
    std::vector<Found> found;
    for (const std::vector<Found>& block : blocks) {
      const auto first = std::lower_bound(block.begin(), block.end(), firstKey(part), isBefore);
      const auto end = part + 1 < kParts ? std::lower_bound(first, block.end(), firstKey(part + 1), isBefore) : block.end();
      found.insert(found.end(), first, end);
    }
    // a cell whose outermost points do not see each other is divided by a wall, and left out
    found = outermost(std::move(found));
    forEachCell(found, [&](size_t first, size_t end) {
      bool is_divided = false;
      for (size_t a = first; a < end; ++a) {
        for (size_t b = a + 1; b < end && !is_divided; ++b)
          is_divided =
              standsBetween(transport.rays(), cell_m, found[a].position, found[a].normal, found[b].position, found[b].normal);
      }
      if (is_divided)
        ++divided[part];
      else
        parts[part].insert(parts[part].end(), found.data() + first, found.data() + end);
    });
  });
  for (std::vector<Found>& part : parts) {
    points_.insert(points_.end(), part.begin(), part.end());
    part = {};
  }
  divided_count_ = std::accumulate(divided.begin(), divided.end(), size_t{0});
  forEachCell(points_, [&](size_t first, size_t) {
    keys_.push_back(points_[first].key);
    first_point_.push_back(static_cast<uint32_t>(first));
  });
  first_point_.push_back(static_cast<uint32_t>(points_.size()));
}

SurfaceCache::Found SurfaceCache::middleOf(size_t cell) const {
  const uint32_t first = first_point_[cell], end = first_point_[cell + 1];
  Found middle{keys_[cell], glm::vec3(0.0f), points_[first].normal};
  for (uint32_t p = first; p < end; ++p) middle.position += points_[p].position / static_cast<float>(end - first);
  return middle;
}

glm::vec3 SurfaceCache::acrossCell(const Found& middle, const glm::vec2& share) const {
  const std::array<int, 2> across = acrossAxes(middle.normal);
  const auto facing = static_cast<int>(sideOf(middle.normal) / 2);
  glm::vec3 way(0.0f);
  for (int a = 0; a < 2; ++a) {
    const int axis = across[static_cast<size_t>(a)];
    const float low = std::floor(middle.position[axis] * cells_per_m_ + kOffset) - kOffset;
    way[axis] = (low + share[a]) / cells_per_m_ - middle.position[axis];
  }
  way[facing] = -glm::dot(way, middle.normal) / middle.normal[facing];
  return middle.position + way;
}

// A lamp that stands nearer than cells are wide shines on a spot between the points that were found.
std::unordered_set<uint64_t> SurfaceCache::cubesBesideLamps(const std::vector<Lamp>& lamps) const {
  std::unordered_set<uint64_t> cubes;
  for (const Lamp& lamp : lamps) {
    for (int i = 0; i < 27; ++i) {
      const glm::vec3 aside(static_cast<float>(i % 3 - 1), static_cast<float>(i / 3 % 3 - 1), static_cast<float>(i / 9 - 1));
      cubes.insert(spotOf(lamp.position + aside / cells_per_m_, {1.0f, 0.0f, 0.0f}).key);
    }
  }
  return cubes;
}

// Of the points that were found as many as leave each kLeastRays rays, beginning with any: the first is on the low side in every cell.
std::vector<SurfaceCache::Found> SurfaceCache::measuredPoints(size_t cell, uint32_t most, uint64_t seed, Beside beside) const {
  std::vector<Found> points;
  if (beside == Beside::lamp && is_whole_[cell] != 0) {
    const Found middle = middleOf(cell);
    for (int i = 0; i < kLampGrid * kLampGrid; ++i) {
      const glm::vec2 share = (glm::vec2(i % kLampGrid, i / kLampGrid) + 0.5f) / static_cast<float>(kLampGrid);
      points.push_back({middle.key, acrossCell(middle, share), middle.normal});
    }
    return points;
  }
  const uint32_t first = first_point_[cell], found = first_point_[cell + 1] - first;
  const auto begin = static_cast<uint32_t>(mixSeed(seed, kPointStream, keys_[cell]) % found);
  for (uint32_t p = 0; p < std::min(found, most); ++p) points.push_back(points_[first + (begin + p) % found]);
  return points;
}

// A cell holds all over its cube where nothing stands between the middle of its points and the cube's corners. Otherwise rays that end
// beyond the outermost points go on as paths, which takes longer and is noisier.
void SurfaceCache::findWholeCells(const LightTransport& transport, int thread_count) {
  is_whole_.assign(keys_.size(), 0);
  const float cell_m = 1.0f / cells_per_m_;
  parallelForBlocks(keys_.size(), kDiscoveryBlock, thread_count, [&](uint64_t first_cell, uint64_t end_cell, int) {
    for (size_t cell = first_cell; cell < end_cell; ++cell) {
      const Found middle = middleOf(cell);
      is_whole_[cell] = 1;
      for (int corner = 0; corner < 4 && is_whole_[cell] != 0; ++corner) {
        const glm::vec3 at = acrossCell(middle, {static_cast<float>(corner & 1), static_cast<float>(corner >> 1)});
        if (standsBetween(transport.rays(), cell_m, middle.position, middle.normal, at, middle.normal)) is_whole_[cell] = 0;
      }
    }
  });
}

// What 4 x 4 x 4 cubes have of one side lies together, hashed as one: neighbouring places send their rays to the same surfaces.
size_t SurfaceCache::firstSlot(uint64_t key) const {
  constexpr uint64_t kLow = 3;
  const uint64_t within =
      (key & kLow) | (key >> (kCoordinateBits - 2) & kLow << 2) | (key >> (2 * kCoordinateBits - 4) & kLow << 4);
  const uint64_t block = key & ~(kLow | kLow << kCoordinateBits | kLow << 2 * kCoordinateBits);
  return ((block * 0x9e3779b97f4a7c15u) >> 32 << 6 | within) & (table_.size() - 1);
}

void SurfaceCache::buildTable() {
  table_.assign(std::bit_ceil(std::max<size_t>(2, 2 * keys_.size())), {});
  constexpr int kMargin = static_cast<int>(255.0f * kMarginShare);
  for (uint32_t cell = 0; cell < keys_.size(); ++cell) {
    Slot made{keys_[cell], cell, {255, 255}, {0, 0}};
    if (is_whole_[cell] != 0) {
      made.low = {0, 0};
      made.high = {255, 255};
    }
    for (uint32_t p = first_point_[cell]; p < first_point_[cell + 1]; ++p) {
      const Spot spot = spotOf(points_[p].position, points_[p].normal);
      for (size_t a = 0; a < 2; ++a) {
        made.low[a] = static_cast<uint8_t>(std::min<int>(made.low[a], std::max(0, spot.across[a] - kMargin)));
        made.high[a] = static_cast<uint8_t>(std::max<int>(made.high[a], std::min(255, spot.across[a] + kMargin)));
      }
    }
    size_t slot = firstSlot(made.key);
    while (table_[slot].cell != kNone) slot = (slot + 1) & (table_.size() - 1);
    table_[slot] = made;
  }
}

uint32_t SurfaceCache::cellAt(const glm::vec3& point, const glm::vec3& normal) const {
  const Spot spot = spotOf(point, normal);
  for (size_t at = firstSlot(spot.key);; at = (at + 1) & (table_.size() - 1)) {
    const Slot& slot = table_[at];
    if (slot.cell == kNone) return kNone;
    if (slot.key != spot.key) continue;
    const auto isWithin = [&](size_t a) { return spot.across[a] >= slot.low[a] && spot.across[a] <= slot.high[a]; };
    return isWithin(0) && isWithin(1) ? slot.cell : kNone;
  }
}

// Direct light at a few points of every cell, and where their rays end. What they meet that is no cell, or one that is divided, is
// followed as a path at once.
void SurfaceCache::measure(const LightTransport& transport, const SurfaceCacheOptions& options, int thread_count) {
  Progress progress("cells of surface lit", static_cast<int64_t>(keys_.size()));
  direct_.assign(keys_.size() * group_count_, glm::vec3(0.0f));
  link_share_.assign(keys_.size(), 0.0f);
  std::vector<std::vector<Link>> block_links(blockCount(keys_.size()));
  std::vector<uint32_t> link_count(keys_.size(), 0);
  const std::unordered_set<uint64_t> beside_lamps = cubesBesideLamps(transport.scene().light.lamps);
  parallelForBlocks(keys_.size(), kBlock, thread_count, [&](uint64_t first_cell, uint64_t end_cell, int) {
    std::vector<Link>& links = block_links[first_cell / kBlock];
    std::vector<SurfacePoint> hits;
    for (size_t cell = first_cell; cell < end_cell; ++cell) {
      const auto addDirect = [&](const GroupedLight& light, float weight) {
        for (size_t g = 0; g < group_count_; ++g) direct_[cell * group_count_ + g] += light[g] * weight;
      };
      const Beside beside = beside_lamps.count(keys_[cell] & kCubeBits) > 0 ? Beside::lamp : Beside::none;
      const std::vector<Found> points =
          measuredPoints(cell, static_cast<uint32_t>(std::max(1, options.rays_per_cell / kLeastRays)), options.seed, beside);
      const auto point_count = static_cast<int>(points.size());
      const int rays = std::max(kLeastRays, options.rays_per_cell / point_count / kLeastRays * kLeastRays);
      const float ray_share = kPi / static_cast<float>(rays * point_count);
      link_share_[cell] = ray_share / kPi;
      for (int p = 0; p < point_count; ++p) {
        const Found& point = points[static_cast<size_t>(p)];
        const glm::dvec3 from(point.position + point.normal * transport.nudge());
        const uint64_t seed = mixSeed(options.seed, kCellStream, keys_[cell], p);
        // without bounces: what arrives from emission, lamps, suns and sky
        addDirect(transport.gatherIrradiance(from, point.normal, {rays, 0}, seed, &hits).groups,
                  1.0f / static_cast<float>(point_count));
        for (size_t i = 0; i < hits.size(); ++i) {
          if (!hits[i].isSurface()) continue;
          const uint32_t other = cellAt(hits[i].position, hits[i].normal);
          if (other == kNone) {
            addDirect(transport.reflected(hits[i], mixSeed(seed, kRestStream, i)), ray_share);
            continue;
          }
          // in 16 bits a channel, since there are as many links as rays
          Link link{other, {}};
          for (int c = 0; c < 3; ++c)
            link.reflectance[c] = static_cast<uint16_t>(std::min(65535.0f, hits[i].reflectance[c] / kReflectanceStep + 0.5f));
          links.push_back(link);
          ++link_count[cell];
        }
      }
    }
    progress.advance(static_cast<int64_t>(end_cell - first_cell));
  });
  // in the order of cells, whatever thread measured them
  for (std::vector<Link>& links : block_links) {
    links_.insert(links_.end(), links.begin(), links.end());
    links = {};
  }
  // links of a cell side by side, as the exchange reads them
  first_link_.assign(1, 0);
  for (const uint32_t count : link_count) first_link_.push_back(first_link_.back() + count);
}

void SurfaceCache::exchange(size_t group, int thread_count) {
  std::vector<glm::vec3> light(keys_.size()), next(keys_.size());
  // begins with direct light: no bounce yet
  for (size_t cell = 0; cell < keys_.size(); ++cell) light[cell] = direct_[cell * group_count_ + group];
  constexpr uint64_t kExchangeBlock = 4096;
  std::vector<float> changes(blockCount(keys_.size(), kExchangeBlock)), mosts(changes.size());
  float change = 1.0f, most = 0.0f;
  int iterations = 0;
  // a bounce an iteration: every cell gathers the last light of those that its rays met
  for (; iterations < kMostIterations && change > kSettled * most; ++iterations) {
    parallelForBlocks(keys_.size(), kExchangeBlock, thread_count, [&](uint64_t first, uint64_t end, int) {
      float &change_here = changes[first / kExchangeBlock], &most_here = mosts[first / kExchangeBlock];
      change_here = most_here = 0.0f;
      for (size_t cell = first; cell < end; ++cell) {
        glm::vec3 sum(0.0f);
        for (uint32_t l = first_link_[cell]; l < first_link_[cell + 1]; ++l) {
          const Link& link = links_[l];
          sum += glm::vec3(link.reflectance[0], link.reflectance[1], link.reflectance[2]) * light[link.cell];
        }
        next[cell] = direct_[cell * group_count_ + group] + sum * (link_share_[cell] * kReflectanceStep);
        change_here = std::max(change_here, largest(glm::abs(next[cell] - light[cell])));
        most_here = std::max(most_here, largest(next[cell]));
      }
    });
    // by block, so that the end does not depend on threads
    change = most = 0.0f;
    for (size_t block = 0; block < changes.size(); ++block) {
      change = std::max(change, changes[block]);
      most = std::max(most, mosts[block]);
    }
    light.swap(next);
  }
  for (size_t cell = 0; cell < keys_.size(); ++cell) irradiance_[cell * group_count_ + group] = light[cell];
  iterations_ = std::max(iterations_, iterations);
}

const glm::vec3* SurfaceCache::irradiance(const glm::vec3& point, const glm::vec3& normal) const {
  const uint32_t cell = cellAt(point, normal);
  return cell == kNone ? nullptr : &irradiance_[cell * group_count_];
}

std::unique_ptr<SurfaceCache> makeSurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                               double spacing_m, const ProbeLightOptions& light, int thread_count) {
  if (!light.caches_surfaces || transport.isBaked()) return nullptr;
  const Bounds bounds = sceneBounds(transport.scene());
  SurfaceCacheOptions options;
  const float share = 0.25f * std::clamp(std::sqrt(64.0f / static_cast<float>(light.place.rays)), 1.0f, 2.0f);
  options.cell_m = std::max(1e-6f, std::min(share * static_cast<float>(spacing_m), glm::length(bounds.max - bounds.min) / 48.0f));
  // a cell keeps a link a ray: in large scenes that is what fills memory
  const int most = std::clamp(raysOfPlace(places.size()) / 8, 2 * kLeastRays, 8 * kLeastRays);
  options.rays_per_cell = std::clamp(light.place.rays / 8, kLeastRays, most);
  // a cell d off that faces a place takes cell² / 4 pi d² of its rays
  const double rays = static_cast<double>(places.size()) * light.place.rays;
  options.reach_m = options.cell_m * static_cast<float>(std::sqrt(rays / (4.0 * kPi * kFewestHits)));
  options.seed = light.seed;
  return std::make_unique<SurfaceCache>(transport, places, options, thread_count);
}

}  // namespace nlg
