// A neural irradiance volume: a small network maps hash-grid features of the point, and the normal, to irradiance.
//
// After the paper of that name (Computer Graphics Forum, 2026), with what it takes from instant neural graphics primitives. Features and
// network are trained together on light at places in air, and are float16 in the look-up.
#pragma once

#include <array>
#include <cstdint>

#include <torch/types.h>
#include <glm/glm.hpp>

#include "validate/light/neural/learner.h"
#include "validate/light/neural/lit_places.h"

namespace nlg {

// A multi-resolution hash grid of features, for neural volumes.
//
// Müller, Evans, Schied and Keller, "Instant Neural Graphics Primitives with a Multiresolution Hash Encoding" (SIGGRAPH 2022): kLevels
// lattices, each finer than the one before by the same factor; a level whose nodes are no more than the table has rows keeps one for
// each, others share rows by a hash. Features at a place are trilinear between the eight nodes around it.

inline constexpr int kHashLevels = 8, kHashFeatures = 2, kHashOutputs = kHashLevels * kHashFeatures,
                     kHashCorners = 8 * kHashLevels;
inline constexpr int kCoarsestCells = 16;                                      // along the longest axis
inline constexpr double kLeastHashGrowth = 1.41421356, kMostHashGrowth = 2.0;  // from level to level
inline constexpr double kFinestHashCellM = 0.25;                               // that growth within these bounds aims at

class HashGrid {
 public:
  // half_m       half the side of the cube that positions lie in; > 0
  // extent       of the places within the cube: low and high, in [-1, 1]³
  // table_log2   rows of a level's table: 2^table_log2 at most; 4 … 24
  HashGrid(double half_m, const glm::vec3& low, const glm::vec3& high, int table_log2);

  size_t rowCount() const { return row_count_; }  // of all levels, kHashFeatures numbers each

  // The rows that a place reads, level by level, and their shares, which sum to 1 in each level.
  // position   in the cube; beyond the extent it is that of the nearest place in it
  struct Corners {
    std::array<uint32_t, kHashCorners> row;
    std::array<float, kHashCorners> share;
  };
  void cornersAt(const float* position_3, Corners* corners) const;

  // features   kHashOutputs, level by level
  // table      rowCount() x kHashFeatures
  void featuresAt(const float* position_3, const float* table, float* features) const;

 private:
  struct Level {
    float scale = 0.0f;  // cells to a unit of the cube
    std::array<uint32_t, 3> nodes{};
    uint32_t first_row = 0;
    uint32_t mask = 0;  // of the hash; 0: a row for each node
  };
  glm::vec3 low_, high_;
  std::array<Level, kHashLevels> levels_;
  size_t row_count_ = 0;
};

// Features of a batch, differentiable by the table.
// position   B x 3 or wider, of which the first three are read
// table      rowCount() * kHashFeatures, flat
// returns    B x kHashOutputs
// grid must outlive the backward pass.
torch::Tensor hashFeatures(const HashGrid& grid, const torch::Tensor& position, const torch::Tensor& table);

struct NeuralVolumeOptions {
  int table_log2 = 14;  // rows of a level: 2^table_log2 at most; 4 … 24
  int width = 64;       // of the two hidden layers
  int64_t batch = 4096;
  TrainingOptions training;
};

// split   learned not empty
LearnedLight trainNeuralVolume(const LitPlaces& lit, const PlaceSplit& split, const NeuralVolumeOptions& options);

}  // namespace nlg
