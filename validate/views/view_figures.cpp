#include "validate/views/view_figures.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "light/directions.h"
#include "render/tone.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

float labCurve(float share) {
  constexpr float kBreak = 216.0f / 24389.0f, kSlope = 24389.0f / 27.0f;
  return share > kBreak ? std::cbrt(share) : (kSlope * share + 16.0f) / 116.0f;
}

double squareSum(const glm::vec3& rgb) {
  const glm::dvec3 wide(rgb);
  return glm::dot(wide, wide);
}

double over(double a, double b) { return b > 0.0 ? a / b : 0.0; }

glm::vec3 shownColour(const Sight& sight, const glm::vec3& irradiance, double exposure) {
  return labOf(static_cast<float>(exposure) * (sight.albedo * irradiance / kPi + sight.shine));
}

// Samples by the cube of side kRingM that their receivers lie in.
class Neighbours {
 public:
  explicit Neighbours(const Sights& sights) : sights_(sights) {
    for (uint32_t i = 0; i < sights.samples.size(); ++i) {
      if (sights.samples[i].kind == Sight::Kind::receiver) cubes_[keyOf(cubeOf(i))].push_back(i);
    }
  }

  // The least of the values of samples around one, itself among them.
  float leastAround(uint32_t sample, const std::vector<float>& values) const {
    const Receiver& receiver = sights_.samples[sample].receiver;
    const glm::i64vec3 centre = cubeOf(sample);
    float least = values[sample];
    for (int i = 0; i < 27; ++i) {
      const auto found = cubes_.find(keyOf(centre + glm::i64vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (found == cubes_.end()) continue;
      for (const uint32_t other : found->second) {
        const Receiver& there = sights_.samples[other].receiver;
        if (values[other] < least && glm::dot(there.normal, receiver.normal) > kRingNormal &&
            glm::distance(there.position_m, receiver.position_m) <= kRingM)
          least = values[other];
      }
    }
    return least;
  }

 private:
  glm::i64vec3 cubeOf(uint32_t sample) const {
    return glm::i64vec3(glm::floor(sights_.samples[sample].receiver.position_m / kRingM));
  }
  static uint64_t keyOf(const glm::i64vec3& cube) {
    return mixSeed(static_cast<uint64_t>(cube.x), static_cast<uint64_t>(cube.y), static_cast<uint64_t>(cube.z));
  }

  const Sights& sights_;
  std::unordered_map<uint64_t, std::vector<uint32_t>> cubes_;
};

// All figures but the count.
std::array<double*, 6> numbersOf(ViewFigures* f) {
  return {&f->colour, &f->energy, &f->off.brighter, &f->off.darker, &f->below_eighth, &f->ringing};
}

// A view darker than what the eye adapts to is exposed as if that light were everywhere.
double exposureOf(const Sights& sights, const ViewTruth& truth) {
  if (truth.adapted <= truth.median) return automaticExposure(pictureOf(sights, "truth", truth.at));
  std::vector<LightAnswer> even(truth.at.size());
  for (LightAnswer& at : even) at.irradiance = glm::vec3(static_cast<float>(truth.adapted));
  return automaticExposure(pictureOf(sights, "even light", even));
}

}  // namespace

glm::vec3 labOf(const glm::vec3& linear_rgb) {
  const glm::vec3 rgb = glm::clamp(linear_rgb, glm::vec3(0.0f), glm::vec3(1.0f));
  // each row over its own sum: shares of the white point
  const float x = labCurve((0.4124564f * rgb.r + 0.3575761f * rgb.g + 0.1804375f * rgb.b) / 0.9504700f);
  const float y = labCurve((0.2126729f * rgb.r + 0.7151522f * rgb.g + 0.0721750f * rgb.b) / 1.0000001f);
  const float z = labCurve((0.0193339f * rgb.r + 0.1191920f * rgb.g + 0.9503041f * rgb.b) / 1.0888300f);
  return {116.0f * y - 16.0f, 500.0f * (x - y), 200.0f * (y - z)};
}

float hyAb(const glm::vec3& lab_a, const glm::vec3& lab_b) {
  const glm::vec3 d = lab_a - lab_b;
  return std::fabs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
}

double medianLight(const Sights& sights, const std::vector<LightAnswer>& truth) {
  std::vector<double> lit;
  for (size_t i = 0; i < truth.size(); ++i) {
    const double light = luminanceOf(truth[i].irradiance);
    if (sights.samples[i].kind == Sight::Kind::receiver && light > 0.0) lit.push_back(light);
  }
  return medianOf(std::move(lit));
}

ViewTruth truthOf(const ViewSurfaces& surfaces, std::vector<LightAnswer> received, double brightest, int thread_count) {
  const Sights& sights = surfaces.sights;
  ViewTruth truth;
  // the exposure of truth serves all methods: a method that is too bright looks too bright
  truth.at = std::move(received);
  truth.median_noise = medianNoise(truth.at);
  truth.median = medianLight(sights, truth.at);
  truth.least = kLeastLight * brightest;
  truth.adapted = std::max(truth.median, truth.least);
  truth.exposure = exposureOf(sights, truth);
  // noise of truth as errors are measured: over the root mean square of irradiance, and as colour difference
  std::vector<float> light(truth.at.size(), 0.0f);
  double squares = 0.0, variance = 0.0, colour = 0.0;
  uint64_t receivers = 0;
  for (size_t i = 0; i < truth.at.size(); ++i) {
    const Sight& sight = sights.samples[i];
    if (sight.kind != Sight::Kind::receiver) continue;
    const LightAnswer& at = truth.at[i];
    ++receivers;
    light[i] = static_cast<float>(luminanceOf(at.irradiance));
    squares += squareSum(at.irradiance);
    variance += squareSum(at.deviation);
    colour +=
        hyAb(shownColour(sight, at.irradiance, truth.exposure), shownColour(sight, at.irradiance + at.deviation, truth.exposure));
  }
  truth.noise = std::sqrt(over(variance, squares));
  truth.colour_noise = colour / static_cast<double>(std::max<uint64_t>(1, receivers));
  // the least truth nearby, on surfaces of like normal: an answer below it is a dark ring
  const Neighbours neighbours(sights);
  truth.least_nearby.resize(light.size(), 0.0f);
  parallelFor(sights.height, thread_count, [&](uint64_t row, int) {
    for (uint64_t i = row * sights.width; i < (row + 1) * sights.width; ++i) {
      if (sights.samples[i].kind == Sight::Kind::receiver)
        truth.least_nearby[i] = neighbours.leastAround(static_cast<uint32_t>(i), light);
    }
  });
  return truth;
}

ViewFiguresByClass viewFigures(const ViewSurfaces& surfaces, const ViewTruth& truth, const std::vector<LightAnswer>& answers) {
  ViewFiguresByClass figures;
  std::array<double, kViewClassCount> right_sum{}, given_sum{};  // of luminances
  // black: below what an eye adapted to the view tells from black
  const double black = kBlackOfMedian * truth.adapted;
  for (size_t i = 0; i < answers.size(); ++i) {
    const Sight& sight = surfaces.sights.samples[i];
    if (sight.kind != Sight::Kind::receiver) continue;
    const glm::vec3 &right = truth.at[i].irradiance, &given = answers[i].irradiance;
    const double light = luminanceOf(right), answer = luminanceOf(given);
    // at most: channels whose noise goes up and down together
    const double deviation = luminanceOf(truth.at[i].deviation);
    const double most = light + kSureDeviations * deviation, least = light - kSureDeviations * deviation;
    // what a viewer sees: the difference of displayed colours at truth's exposure
    const double colour = hyAb(shownColour(sight, right, truth.exposure), shownColour(sight, given, truth.exposure));
    // ring: clearly darker than all truth nearby, and by more than noise explains
    const bool is_ring = truth.least_nearby[i] > black && answer < kRingDarker * truth.least_nearby[i] &&
                         light - answer > kSureDeviations * deviation;
    for (size_t c = 0; c < kViewClassCount; ++c) {
      if (!surfaces.isOf(i, static_cast<ViewClass>(c))) continue;
      ViewFigures& f = figures[c];
      ++f.receivers;
      right_sum[c] += light;
      given_sum[c] += answer;
      f.colour += colour;
      f.ringing += is_ring;
      if (!(std::max(light, answer) > black)) continue;
      f.off.brighter += answer > kOffFactor * most;
      f.off.darker += kOffFactor * answer < least;
      f.below_eighth += answer < kEighth * least;
    }
  }
  for (size_t c = 0; c < kViewClassCount; ++c) {
    ViewFigures& f = figures[c];
    const auto count = static_cast<double>(std::max<uint64_t>(1, f.receivers));
    for (double* share : {&f.colour, &f.off.brighter, &f.off.darker, &f.below_eighth, &f.ringing}) *share /= count;
    if (right_sum[c] > 0.0) f.energy = given_sum[c] / right_sum[c];
  }
  return figures;
}

ViewFiguresByClass meanFigures(const std::vector<ViewFiguresByClass>& views) {
  ViewFiguresByClass mean;
  for (size_t c = 0; c < kViewClassCount; ++c) {
    const bool by_receivers = static_cast<ViewClass>(c) != ViewClass::all;
    double weights = 0.0;
    const auto sums = numbersOf(&mean[c]);
    mean[c].energy = 0.0;
    for (const ViewFiguresByClass& view : views) {
      ViewFigures f = view[c];
      const double weight = by_receivers ? static_cast<double>(f.receivers) : f.receivers > 0 ? 1.0 : 0.0;
      weights += weight;
      mean[c].receivers += f.receivers;
      const auto numbers = numbersOf(&f);
      for (size_t n = 0; n < sums.size(); ++n) *sums[n] += weight * *numbers[n];
    }
    for (double* sum : sums) *sum = over(*sum, weights);
  }
  return mean;
}

}  // namespace nlg
