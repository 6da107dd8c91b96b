// Caches the irradiance at a scene's surfaces, in cells of surface: all bounces after a ray's first hit, traced once.
//
// A cell is what of the surfaces lies in one cube of a lattice and faces one of six ways. Each cell measures direct light and
// notes where its rays end; what cells send each other is then iterated to its end, without rays. Cells that a wall divides (a
// floor that runs under it) are not used: paths that meet them go on. For what probes are solved from: ground truth never reads it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <unordered_set>
#include <vector>

#include "light/light_transport.h"
#include "light/probe_light.h"

namespace nlg {

struct SurfaceCacheOptions {
  float cell_m = 0.25f;      // side of a cube, > 0
  int rays_per_cell = 16;    // >= 8
  int discovery_rays = 24;   // from every place, to find the cells
  float reach_m = INFINITY;  // no place finds cells that are further off
  uint64_t seed = 1;
};

class SurfaceCache {
 public:
  // places   in air, relative to the scene's origin: the cells are those that their rays meet. Those that follow one another should be
  //          neighbours
  // The same bits for any number of threads.
  SurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places, const SurfaceCacheOptions& options,
               int thread_count);

  // Irradiance of the surface at a point that faces this way, one of each group of lights (LightTransport::groupCount); null where no
  // cell is, or one that is not used.
  const glm::vec3* irradiance(const glm::vec3& point, const glm::vec3& normal) const;

  size_t cellCount() const { return keys_.size() + divided_count_; }
  size_t dividedCount() const { return divided_count_; }
  int iterations() const { return iterations_; }

 private:
  static constexpr uint32_t kNone = ~0u;
  static constexpr size_t kPointsPerCell = 4;

  // A surface point that a ray met, and the cell that it lies in.
  struct Found {
    uint64_t key;
    glm::vec3 position, normal;
  };
  // Where a point lies: its cell, and where across that, in 255ths of its side.
  struct Spot {
    uint64_t key;
    std::array<uint8_t, 2> across;
  };
  // A quarter of a cache line, all that a look-up needs to know of a cell.
  struct Slot {
    uint64_t key = 0;
    uint32_t cell = kNone;
    std::array<uint8_t, 2> low{}, high{};  // across the cell: between these it holds
  };
  struct Link {
    uint32_t cell;                        // that a ray ended in
    std::array<uint16_t, 3> reflectance;  // of the point where it did, in steps of kReflectanceStep
  };

  Spot spotOf(const glm::vec3& point, const glm::vec3& normal) const;
  uint32_t cellAt(const glm::vec3& point, const glm::vec3& normal) const;  // one that holds there; kNone without
  std::vector<Found> outermost(std::vector<Found> found) const;
  void findCells(const LightTransport& transport, const std::vector<glm::dvec3>& places, const SurfaceCacheOptions& options,
                 int thread_count);
  void addCells(const LightTransport& transport, const std::vector<std::vector<Found>>& blocks, int thread_count);
  enum class Beside : uint8_t { none, lamp };
  // Between the points that were found.
  Found middleOf(size_t cell) const;
  // On the plane through it. share   of the cell's side, from its low corner, along the axes across the one that it faces
  glm::vec3 acrossCell(const Found& middle, const glm::vec2& share) const;
  std::unordered_set<uint64_t> cubesBesideLamps(const std::vector<Lamp>& lamps) const;
  // Where direct light is measured: `most` of the points that were found; of a whole cell beside a lamp, all over it.
  std::vector<Found> measuredPoints(size_t cell, uint32_t most, uint64_t seed, Beside beside) const;
  void findWholeCells(const LightTransport& transport, int thread_count);
  void buildTable();
  size_t firstSlot(uint64_t key) const;  // where the search for a cell begins
  void measure(const LightTransport& transport, const SurfaceCacheOptions& options, int thread_count);
  void exchange(size_t group, int thread_count);

  float cells_per_m_;
  size_t group_count_;
  std::vector<uint64_t> keys_;         // by cell, rising
  std::vector<uint32_t> first_point_;  // by cell, into points_; one more at the end
  std::vector<Found> points_;
  std::vector<uint8_t> is_whole_;     // by cell
  std::vector<glm::vec3> direct_;     // by cell and group: irradiance of lamps, suns, sky, emitters, and of what is no cell
  std::vector<uint32_t> first_link_;  // by cell, into links_; one more at the end
  std::vector<Link> links_;
  std::vector<float> link_share_;      // by cell: what a link's radiance times albedo adds to irradiance
  std::vector<glm::vec3> irradiance_;  // by cell and group
  std::vector<Slot> table_;            // open addressing, by hash of the key
  size_t divided_count_ = 0;
  int iterations_ = 0;
};

// As every bake has it, and whoever is held against one: cells of a quarter of the probes' spacing, bounces that probes cannot tell
// apart anyway; finer in scenes that are small beside it. None so far off that hardly one ray of all places would end there. Where places have few rays, as in a preview, cells are larger and have few, too.
// light     of the places, whose light is then measured
// returns   null where it asks for none, and of a scene with baked light, whose rays end at their first hit
std::unique_ptr<SurfaceCache> makeSurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                               double spacing_m, const ProbeLightOptions& light, int thread_count);

}  // namespace nlg
