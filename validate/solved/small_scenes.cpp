#include "validate/solved/small_scenes.h"

#include "runtime_eval/numbers/random.h"
#include "scene/mesh_builder.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr float kShellThickness = 1.0f;  // of the room's walls: the outermost probes of the lattice stand in them

// A room with walls, floor and ceiling as six slabs; probes at whole metres, and at heights of .4, 1.4 and 2.4 m.
SmallScene makeRoom(const std::string& name, const glm::vec3& low, const glm::vec3& high) {
  SmallScene small;
  small.name = name;
  small.room = {low, high};
  small.lattice = {{0.0f, -0.6f, 0.0f}, {0, 5, 0}, 1.0f};
  for (const int axis : {0, 2}) small.lattice.extent[axis] = static_cast<int>(high[axis]) + 2;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      Bounds slab{low - kShellThickness, high + kShellThickness};
      (upper ? slab.min : slab.max)[axis] = upper ? high[axis] : low[axis];
      small.solids.push_back(slab);
    }
  }
  small.slice_axis = 1;
  small.slice_m = 1.2f;
  return small;
}

SmallScene makeTwoRooms(const std::string& name, bool with_doorway) {
  SmallScene small = makeRoom(name, {0.35f, 0.0f, 0.35f}, {5.65f, 2.7f, 3.65f});
  if (!with_doorway) {
    small.solids.push_back({{2.46f, 0.0f, 0.35f}, {2.54f, 2.7f, 3.65f}});
    return small;
  }
  small.solids.push_back({{2.46f, 0.0f, 0.35f}, {2.54f, 2.7f, 1.4f}});
  small.solids.push_back({{2.46f, 0.0f, 2.4f}, {2.54f, 2.7f, 3.65f}});
  small.solids.push_back({{2.46f, 2.05f, 1.4f}, {2.54f, 2.7f, 2.4f}});
  return small;
}

// Small things, on the floor and in the air, none of them at a probe.
void addClutter(SmallScene& small) {
  Random random(7);
  while (small.solids.size() < 6 + 24) {
    glm::vec3 low, size;
    for (int axis = 0; axis < 3; ++axis) {
      size[axis] = static_cast<float>(random.uniform(0.06, 0.28));
      low[axis] = static_cast<float>(random.uniform(small.room.min[axis], small.room.max[axis] - size[axis]));
    }
    if (random.chance(0.4)) low.y = small.room.min.y;
    const Bounds box{low, low + size};
    bool is_clear = true;
    for (int i = 0; i < small.lattice.count(); ++i) {
      const glm::ivec3 extent = small.lattice.extent;
      const glm::vec3 probe = small.lattice.position({i % extent.x, i / extent.x % extent.y, i / (extent.x * extent.y)});
      const glm::vec3 nearest = glm::clamp(probe, box.min, box.max);
      is_clear &= glm::distance(probe, nearest) > 0.1f;
    }
    if (is_clear) small.solids.push_back(box);
  }
}

void addTable(SmallScene& small) {
  small.solids.push_back({{1.45f, 0.72f, 1.3f}, {3.55f, 0.78f, 2.7f}});
  for (const float x : {1.5f, 3.42f}) {
    for (const float z : {1.35f, 2.57f}) small.solids.push_back({{x, 0.0f, z}, {x + 0.08f, 0.72f, z + 0.08f}});
  }
  small.slice_axis = 2;
  small.slice_m = 2.1f;
}

}  // namespace

bool SmallScene::inAir(const glm::vec3& at) const {
  const auto inside = [&](const Bounds& box) {
    return at.x > box.min.x && at.y > box.min.y && at.z > box.min.z && at.x < box.max.x && at.y < box.max.y && at.z < box.max.z;
  };
  if (!inside(room)) return false;
  for (const Bounds& box : solids) {
    if (inside(box)) return false;
  }
  return true;
}

Scene SmallScene::makeScene() const {
  MeshBuilder mesh;
  const uint32_t material = mesh.addMaterial({glm::vec3(0.6f)});
  for (size_t i = 0; i < solids.size(); ++i) {
    mesh.beginObject("solid " + std::to_string(i), Mobility::structure);
    addBox(mesh, {}, solids[i].min, solids[i].max, material);
  }
  return mesh.finish(name);
}

std::vector<std::string> smallSceneNames() { return {"two_rooms", "doorway", "column", "clutter", "corridor", "table"}; }

SmallScene makeSmallScene(const std::string& name) {
  if (name == "two_rooms") return makeTwoRooms(name, false);
  if (name == "doorway") return makeTwoRooms(name, true);
  SmallScene small = makeRoom(name, {0.35f, 0.0f, 0.35f}, {4.65f, 2.7f, name == "corridor" ? 4.65f : 3.65f});
  if (name == "column") {
    small.solids.push_back({{2.15f, 0.0f, 1.62f}, {2.85f, 2.7f, 2.38f}});
  } else if (name == "clutter") {
    addClutter(small);
  } else if (name == "corridor") {
    small.solids.push_back({{2.4f, 0.0f, 2.4f}, {4.65f, 2.7f, 4.65f}});
  } else if (name == "table") {
    addTable(small);
  } else {
    throw UsageError("--scene", "two_rooms, doorway, column, clutter, corridor or table", name);
  }
  return small;
}

}  // namespace nlg
