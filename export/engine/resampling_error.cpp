#include "export/engine/resampling_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/light_grid/irradiance.h"
#include "runtime_eval/numbers/random.h"

namespace nlg {
namespace {

constexpr int64_t kDrawsAPlace = 50;

// Positions that are uniform in the volume of the used cells.
class CellPlaces {
 public:
  explicit CellPlaces(const ProbeTree& tree) : frame_(tree.frame()) {
    double volume = 0.0;
    tree.forEachCell([&](const ProbeCell& cell) {
      volume += std::pow(cell.side, 3);
      cells_.push_back(cell);
      volume_up_to_.push_back(volume);
    });
  }

  PositionM draw(Random& random) const {
    const double coarse = random.next(), fine = random.uniform(), at = volume_up_to_.back() * (coarse + fine) * 0x1p-32;
    const auto found = std::upper_bound(volume_up_to_.begin(), volume_up_to_.end() - 1, at);
    const ProbeCell& cell = cells_[static_cast<size_t>(found - volume_up_to_.begin())];
    PositionM position_m;
    for (size_t axis = 0; axis < 3; ++axis)
      position_m[axis] = frame_.first_m[axis] + frame_.spacing_m * (cell.low[axis] + cell.side * random.uniform());
    return position_m;
  }

 private:
  ProbeTreeFrame frame_;
  std::vector<ProbeCell> cells_;
  std::vector<double> volume_up_to_;
};

std::array<float, 3> drawNormal(Random& random) {
  const double z = random.uniform(-1.0, 1.0), turn = 6.283185307179586 * random.uniform(), radius = std::sqrt(1.0 - z * z);
  return {static_cast<float>(radius * std::cos(turn)), static_cast<float>(radius * std::sin(turn)), static_cast<float>(z)};
}

std::array<float, 3> drawAxis(Random& random) {
  std::array<float, 3> normal{};
  const uint32_t side = random.below(6);
  normal[side / 2] = side % 2 == 0 ? 1.0f : -1.0f;
  return normal;
}

class Differences {
 public:
  void add(const std::array<float, kShChannels>& exact, const std::array<float, kShChannels>& shown) {
    double square = 0.0;
    for (size_t c = 0; c < exact.size(); ++c) {
      square += std::pow(double{shown[c]} - exact[c], 2);
      light_ += std::pow(double{exact[c]}, 2);
    }
    squares_.push_back(square);
  }

  double light() const { return light_; }
  double rmse() const { return std::sqrt(std::accumulate(squares_.begin(), squares_.end(), 0.0) / light_); }
  double p95() const {
    std::vector<double> squares = squares_;
    const auto rank = static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(squares.size() - 1));
    std::nth_element(squares.begin(), squares.begin() + rank, squares.end());
    return std::sqrt(squares[static_cast<size_t>(rank)] * static_cast<double>(squares.size()) / light_);
  }

 private:
  double light_ = 0.0;
  std::vector<double> squares_;
};

bool isInside(const LightBox& box, const PositionM& position_m) {
  for (size_t axis = 0; axis < 3; ++axis) {
    if (!(position_m[axis] >= box.low_m[axis] && position_m[axis] <= box.high_m[axis])) return false;
  }
  return true;
}

}  // namespace

std::optional<ResamplingError> resamplingError(const LightGrid& grid, const LightBox* box, const EngineIrradiance& irradiance,
                                               int64_t wanted) {
  const CellPlaces places(grid.tree);
  Random random(mixSeed(1, 0x726573616d706c65));
  Differences any, axes;
  int64_t count = 0;
  for (int64_t drawn = 0; drawn < kDrawsAPlace * wanted && count < wanted; ++drawn) {
    const PositionM position_m = places.draw(random);
    const std::array<std::array<float, 3>, 2> normals = {drawNormal(random), drawAxis(random)};
    if (box != nullptr && !isInside(*box, position_m)) continue;
    std::array<std::array<float, kShChannels>, 2> exact;
    bool is_lit = true;
    for (size_t i = 0; i < normals.size(); ++i)
      is_lit = lookUpIrradiance(grid, position_m, normals[i].data(), exact[i].data()) == LightStatus::lit && is_lit;
    if (!is_lit) continue;
    any.add(exact[0], irradiance(position_m, normals[0].data()));
    axes.add(exact[1], irradiance(position_m, normals[1].data()));
    ++count;
  }
  if (any.light() == 0.0 || axes.light() == 0.0) return std::nullopt;
  return ResamplingError{count, any.rmse(), any.p95(), axes.rmse(), axes.p95()};
}

}  // namespace nlg
