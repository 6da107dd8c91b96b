#include "validate/solved/sample_points.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace nlg {
namespace {

constexpr int kLinksOffSlice = 16, kLinksOnSlice = 8;

glm::vec3 vec(const LocalPoint& point) { return {point[0], point[1], point[2]}; }

glm::ivec3 cornerOffset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2 & 1}; }

void addCellPoints(const SmallScene& small, const SampleOptions& options, SamplePoints& points) {
  const int volume_count = options.fit_points + options.test_points;
  const std::vector<LocalPoint> spread = testPoints(volume_count);
  for (int i = 0; i < volume_count; ++i) {
    const LocalPoint& p = spread[i];
    points.cell_points.push_back({0.5f * (p[0] + 1), 0.5f * (p[1] + 1), 0.5f * (p[2] + 1)});
    // every third point or so, spread over the sequence, which is well distributed from its first point on
    const int64_t rank = int64_t{i} * options.test_points;
    const bool is_test = rank / volume_count != (rank + options.test_points) / volume_count;
    points.cell_use.push_back(is_test ? PointUse::test : PointUse::fit);
  }
  points.cell_points.push_back({0, 0, 0});
  points.cell_use.push_back(PointUse::probe);
  const int axis = small.slice_axis, u = (axis + 1) % 3, v = (axis + 2) % 3;
  const float layer = (small.slice_m - small.lattice.first_m[axis]) / small.lattice.spacing_m;
  for (int i = 0; i < kSlicePixelsACell * kSlicePixelsACell; ++i) {
    LocalPoint point{};
    point[axis] = layer - std::floor(layer);
    point[u] = (static_cast<float>(i % kSlicePixelsACell) + 0.5f) / kSlicePixelsACell;
    point[v] = (static_cast<float>(i / kSlicePixelsACell) + 0.5f) / kSlicePixelsACell;
    points.cell_points.push_back(point);
    points.cell_use.push_back(PointUse::slice);
  }
}

// Buckets of points, for neighbours within a cell or the cells beside it.
class Buckets {
 public:
  Buckets(const SamplePoints& points, PointUse first, PointUse second) : points_(points) {
    for (const glm::vec3& p : points.position_m) low_ = glm::min(low_, p), high_ = glm::max(high_, p);
    extent_ = glm::ivec3((high_ - low_) / kSide) + 1;
    members_.resize(size_t(extent_.x) * extent_.y * extent_.z);
    for (uint32_t i = 0; i < points.count(); ++i) {
      if (points.use[i] == first || points.use[i] == second) members_[bucket(cell(points.position_m[i]))].push_back(i);
    }
  }

  // Appends the `count` members nearest to a point, itself left out.
  void nearest(uint32_t point, size_t count, std::vector<uint32_t>* found) const {
    const glm::vec3 at = points_.position_m[point];
    const glm::ivec3 center = cell(at), from = glm::max(center - 1, 0), to = glm::min(center + 1, extent_ - 1);
    std::vector<std::pair<float, uint32_t>> near;
    for (int z = from.z; z <= to.z; ++z) {
      for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) {
          for (const uint32_t other : members_[bucket({x, y, z})]) {
            if (other != point) near.emplace_back(glm::distance(at, points_.position_m[other]), other);
          }
        }
      }
    }
    std::sort(near.begin(), near.end());
    for (size_t k = 0; k < std::min(count, near.size()); ++k) found->push_back(near[k].second);
  }

 private:
  static constexpr float kSide = 0.5f;
  glm::ivec3 cell(const glm::vec3& at) const { return glm::ivec3((at - low_) / kSide); }
  size_t bucket(const glm::ivec3& at) const { return at.x + size_t(extent_.x) * (at.y + size_t(extent_.y) * at.z); }

  const SamplePoints& points_;
  glm::vec3 low_{1e30f}, high_{-1e30f};
  glm::ivec3 extent_{0};
  std::vector<std::vector<uint32_t>> members_;
};

}  // namespace

SamplePoints makeSamplePoints(const SmallScene& small, const SampleOptions& options) {
  SamplePoints points;
  addCellPoints(small, options, points);
  const ProbeLattice& lattice = small.lattice;
  std::vector<int> probe(lattice.count(), -1);
  const auto forEach = [](const glm::ivec3& extent, const auto& visit) {
    for (int z = 0; z < extent.z; ++z) {
      for (int y = 0; y < extent.y; ++y) {
        for (int x = 0; x < extent.x; ++x) visit(glm::ivec3(x, y, z));
      }
    }
  };
  forEach(lattice.extent, [&](const glm::ivec3& at) {
    if (!small.inAir(lattice.position(at))) return;
    probe[lattice.index(at)] = static_cast<int>(points.probe_position_m.size());
    points.probe_position_m.push_back(lattice.position(at));
  });
  forEach(lattice.extent - 1, [&](const glm::ivec3& cell) {
    for (uint32_t c = 0; c < points.cell_points.size(); ++c) {
      const glm::vec3 at = lattice.position(cell) + lattice.spacing_m * vec(points.cell_points[c]);
      const bool off_plane =
          points.cell_use[c] == PointUse::slice && std::fabs(at[small.slice_axis] - small.slice_m) > 0.01f * lattice.spacing_m;
      if (off_plane || !small.inAir(at)) continue;
      std::array<int, kCornerCount> around;
      for (int corner = 0; corner < kCornerCount; ++corner) around[corner] = probe[lattice.index(cell + cornerOffset(corner))];
      if (*std::max_element(around.begin(), around.end()) < 0) return;
      points.position_m.push_back(at);
      points.use.push_back(points.cell_use[c]);
      points.cell_point.push_back(c);
      points.probe.push_back(around);
    }
  });
  return points;
}

std::vector<LocalPoint> localPoints(const SamplePoints& points) {
  std::vector<LocalPoint> local;
  for (const LocalPoint& in_cell : points.cell_points) {
    for (int corner = 0; corner < kCornerCount; ++corner) {
      const glm::vec3 at = vec(in_cell) - glm::vec3(cornerOffset(corner));
      local.push_back({at.x, at.y, at.z});
    }
  }
  return local;
}

std::vector<std::array<float, kCornerCount>> SamplePoints::tent() const {
  const std::vector<LocalPoint> local = localPoints(*this);
  std::vector<std::array<float, kCornerCount>> weights(count());
  for (size_t i = 0; i < count(); ++i) {
    for (int corner = 0; corner < kCornerCount; ++corner) {
      if (probe[i][corner] >= 0) weights[i][corner] = nlg::tent(local[cell_point[i] * kCornerCount + corner]);
    }
  }
  return weights;
}

std::vector<uint8_t> seeEachOther(const RayScene& rays, const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
  std::vector<uint8_t> open(a.size());
  SegmentPacket packet;
  for (size_t begin = 0; begin < a.size(); begin += kPacketSize) {
    const int count = static_cast<int>(std::min<size_t>(kPacketSize, a.size() - begin));
    for (int i = 0; i < kPacketSize; ++i) {
      const size_t s = begin + std::min(i, count - 1);
      packet.origin_x[i] = a[s].x;
      packet.origin_y[i] = a[s].y;
      packet.origin_z[i] = a[s].z;
      packet.direction_x[i] = b[s].x - a[s].x;
      packet.direction_y[i] = b[s].y - a[s].y;
      packet.direction_z[i] = b[s].z - a[s].z;
    }
    const uint32_t hits = rays.occluded(packet, count);
    for (int i = 0; i < count; ++i) open[begin + i] = !(hits >> i & 1);
  }
  return open;
}

PointLinks linkPoints(const RayScene& rays, const SamplePoints& points) {
  const Buckets volume(points, PointUse::fit, PointUse::test), slice(points, PointUse::slice, PointUse::slice);
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  std::vector<uint32_t> near;
  for (uint32_t i = 0; i < points.count(); ++i) {
    near.clear();
    volume.nearest(i, kLinksOffSlice, &near);
    if (points.use[i] == PointUse::slice) slice.nearest(i, kLinksOnSlice, &near);
    for (const uint32_t other : near) pairs.emplace_back(std::min(i, other), std::max(i, other));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<glm::vec3> a, b;
  for (const auto& [i, j] : pairs) a.push_back(points.position_m[i]), b.push_back(points.position_m[j]);
  const std::vector<uint8_t> open = seeEachOther(rays, a, b);

  PointLinks table;
  table.first.assign(points.count() + 1, 0);
  for (size_t p = 0; p < pairs.size(); ++p) {
    if (!open[p]) continue;
    table.links.push_back({pairs[p].first, pairs[p].second, glm::distance(a[p], b[p])});
    ++table.first[pairs[p].first + 1];
    ++table.first[pairs[p].second + 1];
  }
  std::partial_sum(table.first.begin(), table.first.end(), table.first.begin());
  std::vector<uint32_t> next(table.first.begin(), table.first.end() - 1);
  table.of.resize(2 * table.links.size());
  for (uint32_t l = 0; l < table.links.size(); ++l) {
    table.of[next[table.links[l].a]++] = l;
    table.of[next[table.links[l].b]++] = l;
  }
  return table;
}

}  // namespace nlg
