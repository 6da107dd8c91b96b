// Thins a grid for the light that it holds: functions that the bare tent can replace, and probes that those around can
// replace, are left out. Other light may need them.
//
// Held against each other are what look-ups give and what was measured at places in air. Close to surfaces, where few of those places
// are and where leaks are seen, a look-up is held against what it gave with everything.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "light/probe_light.h"

namespace nlg {

struct Thinned {
  uint64_t functions = 0;        // of probes, that became bare tents
  uint64_t probes = 0;           // that lost all weight: they hold no light, and look-ups pass them by
  double largest_change = 0.0;   // of a look-up at any of the places, over the light there
  glm::dvec3 largest_at_m{0.0};  // that place, relative to the scene's origin
};

// Of places in air one in so many is enough to begin from.
inline constexpr size_t kBesideEvery = 3;

// Three places in front of surfaces for one in `every` places in air, 3 % of reach_m away from them: before one, in an edge, in a corner, as far as
// rays find these within reach_m. A pure function of its arguments.
std::vector<glm::dvec3> placesBesideSurfaces(const RayScene& rays, const std::vector<glm::dvec3>& places, double reach_m,
                                             uint64_t seed, size_t every = 1);

class GridThinner {
 public:
  // grid        with functions, in the world's coordinates; must outlive this object, and is what thinTo changes
  // origin_m    of the scene: places are relative to it
  // measured    at places in air: of all light, or of each group by itself; as many as `light`
  // beside      places that nothing was measured at
  // light       by probe, solved for with the grid as it is
  // dark_share  > 0, of the mean light: added to a place's own where its error is taken as a share of it
  GridThinner(LightGrid* grid, const glm::dvec3& origin_m, const std::vector<glm::dvec3>& places,
              const std::vector<const std::vector<LightSh>*>& measured, const std::vector<glm::dvec3>& beside,
              const std::vector<const std::vector<LightSh>*>& light, double dark_share, int thread_count);

  // Leaves out whatever adds no more than the square of this to the mean square error, as shares of light, of the places that read it,
  // and four times this to the error at any one of them. The same for any number of threads. Light is to be solved for anew afterwards.
  // error   in [0, 1]; of several calls each at least that of the one before
  void thinTo(double error);

  const Thinned& thinned() const { return thinned_; }

 private:
  static constexpr int kCorners = 8;
  enum class Left : uint8_t { tent, nothing };

  struct Place {
    glm::dvec3 at_m{0.0};
    std::array<uint32_t, kCorners> probe{};
    std::array<float, kCorners> weight{}, tent{};  // as the probe has it now, and its bare tent's
    float sum = 0.0f;                              // of weights
    float square = 0.0f, first_square = 0.0f;      // of the error as a share of light: now, and before anything was left out
  };
  struct Reading {
    uint32_t place;
    uint8_t corner;
  };
  struct Trial {
    bool is_allowed = true;
    double loss = 0.0;  // squares that it adds, the mean of the places that read the probe; what erred much before counts less
  };

  void read(const glm::dvec3& origin_m, const glm::dvec3& at_m, Place* place) const;
  void indexReadings();
  void indexEdges();
  void setTargets(const std::vector<const std::vector<LightSh>*>& measured, size_t measured_count, double dark_share);
  float squareOf(size_t place, const std::vector<LightSh>& blends, float sum) const;
  const std::vector<LightSh>& blendsWith(size_t place, int corner, float weight, std::vector<LightSh>* blends) const;
  bool baresEdge(uint32_t probe) const;
  bool isCandidate(uint32_t probe, Left left) const;
  Trial tryOut(uint32_t probe, Left left, float most_at_one, std::vector<LightSh>* scratch) const;
  void leaveOut(uint32_t probe, Left left);
  void pass(Left left, double error);
  void noteLargestChange();

  LightGrid* const grid_;
  const int thread_count_;
  const std::vector<const std::vector<LightSh>*> light_;
  std::vector<Place> places_;
  // by place and group
  std::vector<LightSh> blend_;         // weights times light, not divided by their sum
  std::vector<LightSh> target_;        // measured, or as it was
  std::vector<float> unit_;            // of an error
  std::vector<size_t> reading_begin_;  // by probe, into readings_; one more at the end
  std::vector<Reading> readings_;
  std::vector<size_t> edge_begin_;  // by probe, into edges_of_; one more at the end
  std::vector<uint32_t> edges_of_;
  std::vector<uint8_t> edge_weights_;  // by edge of a cell: how many of its two probes have weight
  Thinned thinned_;
};

}  // namespace nlg
