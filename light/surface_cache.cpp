#include "light/surface_cache.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "tool/progress.h"

namespace nlg {
namespace {

constexpr float kPi = 3.14159265f;
constexpr uint64_t kBlock = 64;
constexpr int kCoordinateBits = 20;
constexpr uint64_t kDiscoveryStream = 0x646973, kCellStream = 0x63656c6c, kPathStream = 0x72657374;
constexpr int kMostIterations = 64;
constexpr float kSettled = 1e-4f;      // of the largest irradiance: a change that ends the exchange
constexpr float kMarginShare = 0.05f;  // of a cell: how far beyond the points that were found it holds
constexpr float kLiftShare = 0.05f;    // of a cell: off the surface, to see whether two of its points see each other

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

uint64_t blockCount(size_t count) { return (count + kBlock - 1) / kBlock; }

// stage   its name for people
template <class Work>
void forEachInBlocks(const char* stage, size_t count, int thread_count, const Work& work) {
  Progress progress(stage, static_cast<int64_t>(count));
  parallelFor(blockCount(count), thread_count, [&](uint64_t block, int) {
    const size_t end = std::min<size_t>((block + 1) * kBlock, count);
    for (size_t i = block * kBlock; i < end; ++i) work(i, block);
    progress.advance(static_cast<int64_t>(end - block * kBlock));
  });
}

float largest(const glm::vec3& rgb) { return std::max({rgb.r, rgb.g, rgb.b}); }

}  // namespace

SurfaceCache::SurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                           const SurfaceCacheOptions& options, int thread_count)
    : cells_per_m_(1.0f / options.cell_m), group_count_(transport.groupCount()) {
  const size_t stride = std::max<size_t>(1, (places.size() + options.max_places - 1) / options.max_places);
  const size_t count = (places.size() + stride - 1) / stride;
  std::vector<std::vector<Found>> blocks(blockCount(count));
  forEachInBlocks("places that look for surfaces", count, thread_count, [&](size_t i, uint64_t block) {
    const glm::vec3 from(places[i * stride]);
    const Lattice lattice(mixSeed(options.seed, kDiscoveryStream, i));
    for (int ray = 0; ray < options.discovery_rays; ++ray) {
      const auto [u, v] = lattice.point(ray, options.discovery_rays);
      const glm::vec3 direction = sphereDirection(u, v);
      const auto find = [&](const LightHit& hit) {
        const SurfacePoint point{from + direction * hit.distance, hit.normal, {}};
        blocks[block].push_back({keyOf(point.position, point.normal), point});
      };
      const LightHit hit = transport.rays().lightHit(from, direction);
      if (hit.kind == LightHit::Kind::surface) find(hit);
      const float reach = hit.kind == LightHit::Kind::nothing ? INFINITY : hit.distance;
      LightHit veil = transport.rays().veilHit(from, direction, 0.0f, reach);
      for (; veil.kind == LightHit::Kind::surface;
           veil = transport.rays().veilHit(from, direction, RayScene::justBehind(veil), reach))
        find(veil);
    }
  });
  std::vector<Found> found;
  for (const std::vector<Found>& block : blocks) found.insert(found.end(), block.begin(), block.end());
  addCells(std::move(found));
  buildTable();
  findDivided(transport, thread_count);
  measure(transport, options, thread_count);
  exchange();
}

// Offset by an odd share of a cell: walls like to stand on whole numbers, and would fall into two cells by their last bits.
uint64_t SurfaceCache::keyOf(const glm::vec3& point, const glm::vec3& normal) const {
  uint64_t key = sideOf(normal);
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<int64_t>(std::floor(point[axis] * cells_per_m_ + 0.3717f)) + (1 << (kCoordinateBits - 1));
    key = key << kCoordinateBits | (static_cast<uint64_t>(at) & ((1u << kCoordinateBits) - 1));
  }
  return key;
}

// Of a cell's points those that lie furthest out along the two axes across the way it faces: a wall that divides the cell stands
// between some of them, and what lies further out still may be behind a wall that none of them told of.
void SurfaceCache::keepOutermost(const Found* begin, const Found* end) {
  const auto [u, v] = acrossAxes(begin->point.normal);
  std::array<const Found*, kPointsPerCell> kept{};
  size_t count = 0;
  std::array<float, 4> reach{};
  for (size_t a = 0; a < 2; ++a) {
    const int axis = a == 0 ? u : v;
    const auto [low, high] = std::minmax_element(
        begin, end, [&](const Found& x, const Found& y) { return x.point.position[axis] < y.point.position[axis]; });
    reach[2 * a] = low->point.position[axis] - kMarginShare / cells_per_m_;
    reach[2 * a + 1] = high->point.position[axis] + kMarginShare / cells_per_m_;
    for (const Found* outermost : {low, high}) {
      if (std::find(kept.begin(), kept.begin() + count, outermost) == kept.begin() + count) kept[count++] = outermost;
    }
  }
  for (size_t k = 0; k < count; ++k) points_.push_back(kept[k]->point);
  reach_.push_back(reach);
}

void SurfaceCache::addCells(std::vector<Found> found) {
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.key < b.key; });
  for (size_t begin = 0; begin < found.size();) {
    size_t end = begin;
    while (end < found.size() && found[end].key == found[begin].key) ++end;
    keys_.push_back(found[begin].key);
    first_point_.push_back(static_cast<uint32_t>(points_.size()));
    keepOutermost(&found[begin], &found[0] + end);
    begin = end;
  }
  first_point_.push_back(static_cast<uint32_t>(points_.size()));
}

void SurfaceCache::buildTable() {
  table_.assign(std::bit_ceil(std::max<size_t>(2, 2 * keys_.size())), kNone);
  for (uint32_t cell = 0; cell < keys_.size(); ++cell) {
    size_t slot = mixSeed(keys_[cell]) & (table_.size() - 1);
    while (table_[slot] != kNone) slot = (slot + 1) & (table_.size() - 1);
    table_[slot] = cell;
  }
}

uint32_t SurfaceCache::indexOf(uint64_t key) const {
  for (size_t slot = mixSeed(key) & (table_.size() - 1);; slot = (slot + 1) & (table_.size() - 1)) {
    if (table_[slot] == kNone || keys_[table_[slot]] == key) return table_[slot];
  }
}

void SurfaceCache::findDivided(const LightTransport& transport, int thread_count) {
  is_divided_.assign(keys_.size(), 0);
  const float lift_m = kLiftShare / cells_per_m_;
  forEachInBlocks("cells of surface tried for walls", keys_.size(), thread_count, [&](size_t cell, uint64_t) {
    const auto lifted = [&](uint32_t p) { return points_[p].position + points_[p].normal * lift_m; };
    const uint32_t first = first_point_[cell], end = first_point_[cell + 1];
    for (uint32_t a = first; a < end; ++a) {
      for (uint32_t b = a + 1; b < end; ++b) is_divided_[cell] |= transport.rays().isBlocked(lifted(a), lifted(b));
    }
  });
  divided_count_ = static_cast<size_t>(std::count(is_divided_.begin(), is_divided_.end(), 1));
}

// Direct light at a few points of every cell, and where their rays end. What they meet that is no cell, or one that is divided, is
// followed as a path at once.
void SurfaceCache::measure(const LightTransport& transport, const SurfaceCacheOptions& options, int thread_count) {
  direct_.assign(keys_.size() * group_count_, glm::vec3(0.0f));
  link_share_.assign(keys_.size(), 0.0f);
  std::vector<std::vector<Link>> block_links(blockCount(keys_.size()));
  std::vector<std::map<std::array<float, 3>, uint32_t>> block_reflectances(block_links.size());
  std::vector<uint32_t> link_count(keys_.size(), 0);
  forEachInBlocks("cells of surface lit", keys_.size(), thread_count, [&](size_t cell, uint64_t block) {
    if (is_divided_[cell]) return;
    std::vector<SurfacePoint> hits;
    const auto addDirect = [&](const GroupedLight& light, float weight) {
      for (size_t g = 0; g < group_count_; ++g) direct_[cell * group_count_ + g] += light[g] * weight;
    };
    const uint32_t first = first_point_[cell], points = first_point_[cell + 1] - first;
    const int rays = std::max(8, options.rays_per_cell / static_cast<int>(points) / 8 * 8);
    const float ray_share = kPi / static_cast<float>(rays * static_cast<int>(points));
    link_share_[cell] = ray_share / kPi;
    for (uint32_t p = 0; p < points; ++p) {
      const SurfacePoint& point = points_[first + p];
      const glm::dvec3 from(point.position + point.normal * transport.nudge());
      const uint64_t seed = mixSeed(options.seed, kCellStream, keys_[cell], p);
      addDirect(transport.gatherIrradiance(from, point.normal, {rays, 0}, seed, &hits).groups, 1.0f / static_cast<float>(points));
      for (size_t i = 0; i < hits.size(); ++i) {
        if (!hits[i].isSurface()) continue;
        const uint32_t other = cellAt(hits[i].position, hits[i].normal);
        if (other != kNone) {
          const glm::vec3& r = hits[i].reflectance;
          std::map<std::array<float, 3>, uint32_t>& known = block_reflectances[block];
          const auto [at, is_new] = known.try_emplace({r.r, r.g, r.b}, static_cast<uint32_t>(known.size()));
          block_links[block].push_back({other, at->second});
          ++link_count[cell];
        } else {
          addDirect(transport.reflected(hits[i], mixSeed(seed, kPathStream, i)), ray_share);
        }
      }
    }
  });
  for (size_t block = 0; block < block_links.size(); ++block) {
    const auto first = static_cast<uint32_t>(reflectances_.size());
    reflectances_.resize(first + block_reflectances[block].size());
    for (const auto& [r, at] : block_reflectances[block]) reflectances_[first + at] = {r[0], r[1], r[2]};
    for (const Link& link : block_links[block]) links_.push_back({link.cell, first + link.reflectance});
    block_links[block] = {};
    block_reflectances[block] = {};
  }
  first_link_.assign(1, 0);
  for (const uint32_t count : link_count) first_link_.push_back(first_link_.back() + count);
}

void SurfaceCache::exchange() {
  const Progress progress("bounces between surfaces");
  irradiance_ = direct_;
  for (size_t group = 0; group < group_count_; ++group) exchange(group);
  links_ = {};
  reflectances_ = {};
  points_ = {};
}

void SurfaceCache::exchange(size_t group) {
  std::vector<glm::vec3> direct(keys_.size());
  for (size_t cell = 0; cell < keys_.size(); ++cell) direct[cell] = direct_[cell * group_count_ + group];
  std::vector<glm::vec3> light = direct, next(direct.size());
  float change = 1.0f, most = 0.0f;
  int iterations = 0;
  for (; iterations < kMostIterations && change > kSettled * most; ++iterations) {
    change = most = 0.0f;
    for (size_t cell = 0; cell < light.size(); ++cell) {
      glm::vec3 sum(0.0f);
      for (uint32_t l = first_link_[cell]; l < first_link_[cell + 1]; ++l)
        sum += reflectances_[links_[l].reflectance] * light[links_[l].cell];
      next[cell] = direct[cell] + sum * link_share_[cell];
      change = std::max(change, largest(glm::abs(next[cell] - light[cell])));
      most = std::max(most, largest(next[cell]));
    }
    light.swap(next);
  }
  for (size_t cell = 0; cell < keys_.size(); ++cell) irradiance_[cell * group_count_ + group] = light[cell];
  iterations_ = std::max(iterations_, iterations);
}

uint32_t SurfaceCache::cellAt(const glm::vec3& point, const glm::vec3& normal) const {
  const uint32_t cell = indexOf(keyOf(point, normal));
  if (cell == kNone || is_divided_[cell]) return kNone;
  const auto [u, v] = acrossAxes(normal);
  const std::array<float, 4>& reach = reach_[cell];
  const bool is_inside = point[u] >= reach[0] && point[u] <= reach[1] && point[v] >= reach[2] && point[v] <= reach[3];
  return is_inside ? cell : kNone;
}

const glm::vec3* SurfaceCache::irradiance(const glm::vec3& point, const glm::vec3& normal) const {
  const uint32_t cell = cellAt(point, normal);
  return cell == kNone ? nullptr : &irradiance_[cell * group_count_];
}

std::unique_ptr<SurfaceCache> makeSurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                               double spacing_m, uint64_t seed, int thread_count) {
  if (transport.isBaked()) return nullptr;
  const Bounds bounds = sceneBounds(transport.scene());
  SurfaceCacheOptions options;
  options.cell_m = std::max(1e-6f, std::min(0.25f * static_cast<float>(spacing_m), glm::length(bounds.max - bounds.min) / 48.0f));
  options.seed = seed;
  return std::make_unique<SurfaceCache>(transport, places, options, thread_count);
}

}  // namespace nlg
