#include "scene/procedural/mesh_builder.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "scene/procedural/value_noise.h"

namespace nlg {
namespace {

using Corners = std::array<uint32_t, 4>;  // of a profile's cross-section: low front, low back, high front, high back

Corners addCrossSection(MeshBuilder& mesh, const Placement& placement, const ProfilePoint& point, double z_min, double z_max) {
  Corners corners{};
  corners[0] = mesh.addVertex(placement, {point.x, point.low, z_max});
  corners[1] = mesh.addVertex(placement, {point.x, point.low, z_min});
  if (point.high <= point.low) return {corners[0], corners[1], corners[0], corners[1]};
  corners[2] = mesh.addVertex(placement, {point.x, point.high, z_max});
  corners[3] = mesh.addVertex(placement, {point.x, point.high, z_min});
  return corners;
}

// A sphere of triangles that are nearly equal, all corners at distance one.
struct UnitSphere {
  std::vector<glm::dvec3> points;
  std::vector<glm::uvec3> triangles;
};

UnitSphere icosahedron() {
  const double a = 0.5257311121191336;
  const double b = 0.8506508083520400;
  return {{{-a, b, 0},
           {a, b, 0},
           {-a, -b, 0},
           {a, -b, 0},
           {0, -a, b},
           {0, a, b},
           {0, -a, -b},
           {0, a, -b},
           {b, 0, -a},
           {b, 0, a},
           {-b, 0, -a},
           {-b, 0, a}},
          {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
           {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
}

UnitSphere subdivided(const UnitSphere& coarse) {
  UnitSphere fine{coarse.points, {}};
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  const auto middle = [&](uint32_t a, uint32_t b) {
    const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(fine.points.size()));
    if (is_new) {
      const glm::dvec3 sum = fine.points[a] + fine.points[b];
      fine.points.push_back(sum / std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z));
    }
    return entry->second;
  };
  for (const glm::uvec3& t : coarse.triangles) {
    const uint32_t ab = middle(t.x, t.y);
    const uint32_t bc = middle(t.y, t.z);
    const uint32_t ca = middle(t.z, t.x);
    for (const glm::uvec3& part : {glm::uvec3(t.x, ab, ca), {t.y, bc, ab}, {t.z, ca, bc}, {ab, bc, ca}})
      fine.triangles.push_back(part);
  }
  return fine;
}

}  // namespace

glm::dvec3 Placement::apply(const glm::dvec3& local) const {
  const glm::dvec3 laid = axis == Axis::vertical ? local : glm::dvec3(local.y, -local.x, local.z);
  return position + turned(turn, laid);
}

uint32_t MeshBuilder::addMaterial(const Material& material) {
  scene_.materials.push_back(material);
  return static_cast<uint32_t>(scene_.materials.size() - 1);
}

void MeshBuilder::beginObject(const std::string& name, Mobility mobility) {
  closeObject();
  scene_.objects.push_back({name, static_cast<uint32_t>(scene_.triangles.size()), 0, mobility == Mobility::movable});
}

void MeshBuilder::closeObject() {
  if (scene_.objects.empty()) return;
  SceneObject& last = scene_.objects.back();
  last.triangle_count = static_cast<uint32_t>(scene_.triangles.size()) - last.first_triangle;
  if (last.triangle_count == 0) scene_.objects.pop_back();
}

uint32_t MeshBuilder::addVertex(const Placement& placement, const glm::dvec3& local) {
  const glm::dvec3 p = placement.apply(local);
  scene_.positions.emplace_back(snapped(p.x, kVerticesPerMetre), snapped(p.y, kVerticesPerMetre),
                                snapped(p.z, kVerticesPerMetre));
  return static_cast<uint32_t>(scene_.positions.size() - 1);
}

void MeshBuilder::addTriangle(uint32_t a, uint32_t b, uint32_t c, uint32_t material) {
  if (a == b || b == c || c == a) return;
  scene_.triangles.emplace_back(a, b, c);
  scene_.triangle_material.push_back(material);
}

void MeshBuilder::addQuad(uint32_t a, uint32_t b, uint32_t c, uint32_t d, uint32_t material) {
  addTriangle(a, b, c, material);
  addTriangle(a, c, d, material);
}

Scene MeshBuilder::finish(const std::string& id) {
  closeObject();
  scene_.id = id;
  return std::exchange(scene_, {});
}

void addProfile(MeshBuilder& mesh, const Placement& placement, const std::vector<ProfilePoint>& profile, double z_min,
                double z_max, uint32_t material) {
  Corners left = addCrossSection(mesh, placement, profile.front(), z_min, z_max);
  mesh.addQuad(left[1], left[0], left[2], left[3], material);
  for (size_t i = 1; i < profile.size(); ++i) {
    const Corners right = addCrossSection(mesh, placement, profile[i], z_min, z_max);
    mesh.addQuad(left[0], right[0], right[2], left[2], material);
    mesh.addQuad(right[1], left[1], left[3], right[3], material);
    mesh.addQuad(left[2], right[2], right[3], left[3], material);
    mesh.addQuad(left[1], right[1], right[0], left[0], material);
    left = right;
  }
  mesh.addQuad(left[0], left[1], left[3], left[2], material);
}

void addLathe(MeshBuilder& mesh, const Placement& placement, const std::vector<Ring>& rings, int side_count, uint32_t material) {
  const auto addRing = [&](const Ring& ring) {
    std::vector<uint32_t> points;
    // a ring of radius 0 is one vertex: a cone ends in a point, not in an open hole
    if (ring.radius <= 0.0) return std::vector<uint32_t>(side_count, mesh.addVertex(placement, {0.0, ring.y, 0.0}));
    for (int side = 0; side < side_count; ++side) {
      const glm::dvec3 spoke = turned(turnByDegrees(360.0 * side / side_count), {ring.radius, 0.0, 0.0});
      points.push_back(mesh.addVertex(placement, {spoke.x, ring.y, spoke.z}));
    }
    return points;
  };
  // fans close both ends, the lower one wound downward
  std::vector<uint32_t> below = addRing(rings.front());
  for (int side = 2; side < side_count; ++side) mesh.addTriangle(below[0], below[side], below[side - 1], material);
  for (size_t i = 1; i < rings.size(); ++i) {
    const std::vector<uint32_t> above = addRing(rings[i]);
    for (int side = 0; side < side_count; ++side) {
      const int next = (side + 1) % side_count;
      mesh.addQuad(below[side], below[next], above[next], above[side], material);
    }
    below = above;
  }
  for (int side = 2; side < side_count; ++side) mesh.addTriangle(below[0], below[side - 1], below[side], material);
}

void addBox(MeshBuilder& mesh, const Placement& placement, const glm::dvec3& min, const glm::dvec3& max, uint32_t material) {
  addProfile(mesh, placement, {{min.x, min.y, max.y}, {max.x, min.y, max.y}}, min.z, max.z, material);
}

void addRock(MeshBuilder& mesh, const Placement& placement, const glm::dvec3& radii_m, uint64_t seed, uint32_t material) {
  static const UnitSphere sphere = subdivided(subdivided(icosahedron()));
  std::vector<uint32_t> points;
  for (const glm::dvec3& p : sphere.points) {
    const double dent = 1.0 + 0.33 * fractalNoise(seed, p * 1.7, 2);
    points.push_back(mesh.addVertex(placement, p * dent * radii_m));
  }
  for (const glm::uvec3& t : sphere.triangles) mesh.addTriangle(points[t.x], points[t.y], points[t.z], material);
}

void addHeightfield(MeshBuilder& mesh, const Placement& placement, const Heightfield& field, uint32_t material) {
  const auto point = [&](int x, int z, double height) {
    return mesh.addVertex(placement, {x * field.spacing_m, height, z * field.spacing_m});
  };
  std::vector<uint32_t> top;
  for (int z = 0; z < field.z_count; ++z) {
    for (int x = 0; x < field.x_count; ++x) top.push_back(point(x, z, field.height_m[top.size()]));
  }
  const auto at = [&](int x, int z) { return top[static_cast<size_t>(z) * field.x_count + x]; };
  for (int z = 1; z < field.z_count; ++z) {
    for (int x = 1; x < field.x_count; ++x) mesh.addQuad(at(x - 1, z), at(x, z), at(x, z - 1), at(x - 1, z - 1), material);
  }
  // the rim, counter-clockwise from above, gets a wall down to the bottom, which is a fan about its middle
  std::vector<glm::ivec2> rim;
  for (int x = 0; x + 1 < field.x_count; ++x) rim.emplace_back(x, field.z_count - 1);
  for (int z = field.z_count - 1; z > 0; --z) rim.emplace_back(field.x_count - 1, z);
  for (int x = field.x_count - 1; x > 0; --x) rim.emplace_back(x, 0);
  for (int z = 0; z + 1 < field.z_count; ++z) rim.emplace_back(0, z);
  std::vector<uint32_t> foot;
  for (const glm::ivec2& r : rim) foot.push_back(point(r.x, r.y, field.base_m));
  const glm::dvec2 middle = glm::dvec2(field.x_count - 1, field.z_count - 1) * (0.5 * field.spacing_m);
  const uint32_t centre = mesh.addVertex(placement, {middle.x, field.base_m, middle.y});
  for (size_t i = 0; i < rim.size(); ++i) {
    const size_t next = (i + 1) % rim.size();
    mesh.addQuad(foot[i], foot[next], at(rim[next].x, rim[next].y), at(rim[i].x, rim[i].y), material);
    mesh.addTriangle(foot[next], foot[i], centre, material);
  }
}

}  // namespace nlg
