// Regions of narrow air: points of a lattice that reach each other along its edges. A region is closed, or it is not, for all of
// its points.
#pragma once

#include <optional>
#include <shared_mutex>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

class RayScene;
class Random;

// Unit, even over all directions.
glm::vec3 randomDirection(Random& random);

// Found when they are first asked for, and remembered. Any number of threads may ask at once; answers depend on the scene alone.
class AirRegions {
 public:
  // width_m   of air that somebody can be in, above 0: of a free ball. The lattice's points are a quarter of that apart
  // low, high the scene's box
  AirRegions(const RayScene& rays, float width_m, const glm::vec3& low, const glm::vec3& high);

  // Whether the region around a place is closed. Open is one that is as wide somewhere, goes past the scene's box or is too large to be
  // looked through; and one from which one random look in 200, from all over it, sees wide air or an open region. Ways and looks go along
  // two lines a fiftieth of the width apart: a crack is none. Nothing where none of the lattice's eight points around the place is in
  // its sight: in gaps narrower than a cell.
  std::optional<bool> isClosedAround(const glm::vec3& place) const;

 private:
  struct Hash {
    size_t operator()(const glm::ivec3& point) const;
  };
  using Points = std::unordered_set<glm::ivec3, Hash>;

  struct Enclosed;
  // What a look from a point sees: wide air, another point, or nothing that counts.
  struct Sight {
    bool is_wide = false;
    std::optional<glm::ivec3> point;
  };

  glm::vec3 positionOf(const glm::ivec3& point) const;
  // The first of the eight around a place, by distance, to which a way is open.
  std::optional<glm::ivec3> nearestSeen(const glm::vec3& place) const;
  // Along a line, and along one beside it.
  bool isOpenWay(const glm::vec3& from, const glm::vec3& to) const;
  bool isLinked(const glm::ivec3& a, const glm::ivec3& b) const;
  // Half the width at most, and for whatever lies past the scene's box.
  float clearanceAt(const glm::ivec3& point) const;
  std::optional<bool> known(const glm::ivec3& point) const;
  // Gathers all points that are linked to one. True as soon as one of them is wide, or belongs to a region that is known to be open.
  bool spread(const glm::ivec3& start, Points* points) const;
  Sight look(const glm::ivec3& point, Random& random) const;
  std::optional<bool> judge(const glm::ivec3& point, Enclosed* enclosed) const;
  void lookAround(size_t region_idx, Enclosed* enclosed) const;
  bool isClosed(const glm::ivec3& point) const;
  void remember(const Points& points, bool is_closed) const;

  const RayScene& rays_;
  const float radius_m_, step_m_;
  const glm::vec3 low_, high_;
  mutable std::shared_mutex mutex_;
  mutable std::unordered_map<glm::ivec3, bool, Hash> known_;  // by lattice point: whether its region is closed
};

}  // namespace nlg
