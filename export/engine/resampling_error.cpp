#include "export/engine/resampling_error.h"

#include <algorithm>
#include <cmath>

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
  std::vector<double> squares;
  double light = 0.0, error = 0.0;
  for (int64_t drawn = 0; drawn < kDrawsAPlace * wanted && static_cast<int64_t>(squares.size()) < wanted; ++drawn) {
    const PositionM position_m = places.draw(random);
    const std::array<float, 3> normal = drawNormal(random);
    std::array<float, kShChannels> exact;
    if (box != nullptr && !isInside(*box, position_m)) continue;
    if (lookUpIrradiance(grid, position_m, normal.data(), exact.data()) != LightStatus::lit) continue;
    const std::array<float, kShChannels> shown = irradiance(position_m, normal.data());
    double square = 0.0;
    for (size_t c = 0; c < exact.size(); ++c) {
      square += std::pow(double{shown[c]} - exact[c], 2);
      light += std::pow(double{exact[c]}, 2);
    }
    squares.push_back(square);
    error += square;
  }
  if (squares.empty() || light == 0.0) return std::nullopt;
  const auto rank = static_cast<size_t>(0.95 * static_cast<double>(squares.size() - 1));
  std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(rank), squares.end());
  const auto count = static_cast<double>(squares.size());
  return ResamplingError{static_cast<int64_t>(squares.size()), std::sqrt(error / light),
                         std::sqrt(squares[rank] * count / light)};
}

}  // namespace nlg
