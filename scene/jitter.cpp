#include "scene/jitter.h"

#include <utility>

#include "runtime_eval/numbers/random.h"
#include "scene/model/rotation.h"
#include "scene/solid/closed_shells.h"

namespace nlg {
namespace {

// What one draw does to one object: turned and scaled about its centre, then shifted.
struct Change {
  bool is_dropped = false;
  glm::dvec3 shift_m{0.0};
  Turn turn;
  double scale = 1.0;
};

// Every object draws from a stream of its own, and always the same number of times: options change its size, not its sense.
Change drawChange(const JitterOptions& options, uint64_t jitter, size_t object_idx) {
  Random random(mixSeed(0x6a6974746572, jitter, object_idx));
  Change change;
  change.is_dropped = random.chance(options.drop_share);
  change.shift_m.x = options.move_m * random.uniform(-1.0, 1.0);
  change.shift_m.z = options.move_m * random.uniform(-1.0, 1.0);
  change.shift_m.y = 0.1 * options.move_m * random.uniform(-1.0, 1.0);
  change.turn = turnByDegrees(options.turn_degrees * random.uniform(-1.0, 1.0));
  change.scale = 1.0 + options.scale * random.uniform(-1.0, 1.0);
  return change;
}

// Copies objects into a new scene, each with vertices of its own: two objects that share vertices move apart.
class SceneCopier {
 public:
  explicit SceneCopier(const Scene& source)
      : source_(source), copies_(source.positions.size()), owner_(source.positions.size(), 0) {
    result_.id = source.id;
    result_.origin_m = source.origin_m;
    result_.materials = source.materials;
    result_.images = source.images;
    result_.dropped_triangle_count = source.dropped_triangle_count;
    // what lay on the surfaces lay there for them as they stood
    result_.light = source.light;
    result_.light.baked = {};
  }

  // change is null for what stays exactly where it is
  void copy(const SceneObject& object, const Change* change) {
    ++object_count_;
    const Bounds bounds = objectBounds(source_, object);
    const glm::dvec3 centre = 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
    result_.objects.push_back(object);
    result_.objects.back().first_triangle = static_cast<uint32_t>(result_.triangles.size());
    for (uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
      glm::uvec3 triangle;
      for (int corner = 0; corner < 3; ++corner) triangle[corner] = copyVertex(source_.triangles[i][corner], centre, change);
      result_.triangles.push_back(triangle);
      result_.triangle_material.push_back(source_.triangle_material[i]);
    }
  }

  Scene take() { return std::move(result_); }

 private:
  uint32_t copyVertex(uint32_t vertex, const glm::dvec3& centre, const Change* change) {
    if (owner_[vertex] != object_count_) {
      owner_[vertex] = object_count_;
      copies_[vertex] = static_cast<uint32_t>(result_.positions.size());
      result_.positions.push_back(source_.positions[vertex]);
      copyLook(source_.base_places, vertex, &result_.base_places);
      copyLook(source_.emissive_places, vertex, &result_.emissive_places);
      copyLook(source_.vertex_colours, vertex, &result_.vertex_colours);
      if (change != nullptr) {
        const glm::dvec3 arm = (glm::dvec3(source_.positions[vertex]) - centre) * change->scale;
        result_.positions.back() = glm::vec3(centre + change->shift_m + turned(change->turn, arm));
      }
    }
    return copies_[vertex];
  }

  template <class Value>
  static void copyLook(const std::vector<Value>& source, uint32_t vertex, std::vector<Value>* copy) {
    if (!source.empty()) copy->push_back(source[vertex]);
  }

  const Scene& source_;
  Scene result_;
  uint32_t object_count_ = 0;
  std::vector<uint32_t> copies_, owner_;  // of a source vertex: its latest copy, and for which object that was made
};

}  // namespace

Scene jitterScene(const Scene& scene, const JitterOptions& options, uint64_t jitter) {
  if (jitter == 0) return scene;
  Scene parts = scene;
  splitConnectedComponents(parts, options.structure_share);
  SceneCopier copier(parts);
  for (size_t i = 0; i < parts.objects.size(); ++i) {
    const SceneObject& object = parts.objects[i];
    const Change change = drawChange(options, jitter, i);
    if (!object.movable) copier.copy(object, nullptr);
    if (object.movable && !change.is_dropped) copier.copy(object, &change);
  }
  return copier.take();
}

}  // namespace nlg
