// What arrives at a scene's surfaces, kept in cells of surface: all bounces behind a ray's first hit, found once for all places.
//
// A cell is what of the surfaces lies in one cube of a lattice and faces one of six ways. Each cell measures direct light and
// notes where its rays end; what cells send each other is then iterated to its end, without rays. Cells that a wall divides (a
// floor that runs under it) are not used: paths that meet them go on. For what probes are solved from: ground truth never reads it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "light/light_transport.h"

namespace nlg {

struct SurfaceCacheOptions {
  float cell_m = 0.25f;     // side of a cube, > 0
  int rays_per_cell = 64;   // >= 8
  int discovery_rays = 32;  // from every place, to find the cells
  int max_places = 40000;   // that discover; more are thinned out evenly
  uint64_t seed = 1;
};

class SurfaceCache {
 public:
  // places   in air, relative to the scene's origin: the cells are those that their rays meet, and that the cells' own rays meet
  // The same bits for any number of threads.
  SurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places, const SurfaceCacheOptions& options,
               int thread_count);

  // Irradiance of the surface at a point that faces this way, one of each group of lights (LightTransport::groupCount); null where no
  // cell is, or one that is not used.
  const glm::vec3* irradiance(const glm::vec3& point, const glm::vec3& normal) const;

  size_t cellCount() const { return keys_.size(); }
  size_t dividedCount() const { return divided_count_; }
  int iterations() const { return iterations_; }

 private:
  struct Found {
    uint64_t key;
    SurfacePoint point;
  };
  struct Link {
    uint32_t cell;         // that a ray ended in
    uint32_t reflectance;  // of the point where it did: into reflectances_, since most scenes have few
  };

  uint64_t keyOf(const glm::vec3& point, const glm::vec3& normal) const;
  uint32_t indexOf(uint64_t key) const;                                    // kNone without a cell
  uint32_t cellAt(const glm::vec3& point, const glm::vec3& normal) const;  // one that holds there; kNone without
  void addCells(std::vector<Found> found);
  void keepOutermost(const Found* begin, const Found* end);
  void findDivided(const LightTransport& transport, int thread_count);
  void measure(const LightTransport& transport, const SurfaceCacheOptions& options, int thread_count);
  void exchange();
  void exchange(size_t group);
  void buildTable();

  static constexpr uint32_t kNone = ~0u;
  static constexpr size_t kPointsPerCell = 4;

  float cells_per_m_;
  size_t group_count_;
  std::vector<uint64_t> keys_;         // by cell, rising
  std::vector<uint32_t> first_point_;  // by cell, into points_; one more at the end
  std::vector<SurfacePoint> points_;
  std::vector<std::array<float, 4>> reach_;  // by cell: low and high along the two axes across the way it faces
  std::vector<uint8_t> is_divided_;          // by cell
  std::vector<glm::vec3> direct_;     // by cell and group: irradiance of lamps, suns, sky, emitters, and of what is no cell
  std::vector<uint32_t> first_link_;  // by cell, into links_; one more at the end
  std::vector<Link> links_;
  std::vector<glm::vec3> reflectances_;
  std::vector<float> link_share_;      // by cell: what a link's radiance times albedo adds to irradiance
  std::vector<glm::vec3> irradiance_;  // by cell and group
  std::vector<uint32_t> table_;        // open addressing: cells by hash of their keys
  size_t divided_count_ = 0;
  int iterations_ = 0;
};

// As every bake has it, and whoever is held against one: cells of a quarter of the probes' spacing, bounces that probes cannot tell
// apart anyway; finer in scenes that are small beside it.
// returns   null of a scene with baked light, whose rays end at their first hit
std::unique_ptr<SurfaceCache> makeSurfaceCache(const LightTransport& transport, const std::vector<glm::dvec3>& places,
                                               double spacing_m, uint64_t seed, int thread_count);

}  // namespace nlg
