// Conjugate gradients with a diagonal preconditioner, all three channels at once: they share the matrix.
#include <algorithm>
#include <utility>

#include "export/engine/texel_light.h"
#include "light/directions.h"
#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"

namespace nlg {
namespace {

constexpr uint64_t kNormalStream = 0x6e6f726d616c;
constexpr int kNormals = 6;    // of a place
constexpr int kRounds = 3;     // readings are weighed anew after each
constexpr int kMaxSteps = 80;  // of a round
constexpr double kTolerance = 1e-3;
constexpr float kPull = 0.3f;       // over that of the solve before
constexpr float kMostNoise = 3.0f;  // as probe_light.cpp has it
constexpr uint64_t kBlock = 1024;

// What an engine reads at a place for one normal.
struct Reading {
  ProbeWeights texels;
  std::array<float, kShCount> basis{};  // irradiance of each coefficient
  glm::vec3 irradiance{0.0f};           // what it should be
  float importance = 1.0f;
};

glm::vec3 shownBy(const Reading& reading, const std::vector<LightSh>& light) {
  glm::vec3 sum(0.0f);
  for (int j = 0; j < reading.texels.count; ++j) {
    const LightSh& texel = light[reading.texels.probe[j]];
    for (int k = 0; k < kShCount; ++k) sum += reading.texels.weight[j] * reading.basis[k] * texel[k];
  }
  return sum;
}

float meanOf(const glm::vec3& rgb) { return (rgb.r + rgb.g + rgb.b) / 3.0f; }

class NormalSolver {
 public:
  NormalSolver(std::vector<Reading> readings, std::vector<LightSh> prior, int thread_count)
      : readings_(std::move(readings)), prior_(std::move(prior)), reads_(prior_.size()), thread_count_(thread_count) {
    for (size_t r = 0; r < readings_.size(); ++r) {
      const ProbeWeights& texels = readings_[r].texels;
      for (int j = 0; j < texels.count; ++j) reads_[texels.probe[j]].emplace_back(static_cast<uint32_t>(r), texels.weight[j]);
    }
  }

  std::vector<LightSh> solve(const ProbeLightOptions& options) {
    std::vector<LightSh> light = prior_;
    for (int round = 0; round < kRounds; ++round) {
      weigh(options, light);
      descend(&light);
    }
    return light;
  }

 private:
  template <class Visit>
  void forEach(size_t count, const Visit& visit) const {
    parallelForBlocks(count, kBlock, thread_count_, [&](uint64_t first, uint64_t end, int) {
      for (size_t i = first; i < end; ++i) visit(i);
    });
  }

  static float pullOf(int k, float pull) { return k < 4 ? pull : 3.0f * pull; }

  // As probe_light.cpp weighs samples: shares of the light of the place, by Cauchy's loss.
  void weigh(const ProbeLightOptions& options, const std::vector<LightSh>& light) {
    double sum = 0.0;
    for (const Reading& reading : readings_) sum += std::max(0.0f, meanOf(reading.irradiance));
    const auto mean = static_cast<float>(sum / std::max<double>(1.0, static_cast<double>(readings_.size())) + 1e-12);
    forEach(readings_.size(), [&](size_t r) {
      Reading& reading = readings_[r];
      const glm::vec3 shown = shownBy(reading, light), off = shown - reading.irradiance;
      const float wanted = std::max(0.0f, meanOf(reading.irradiance));
      const float unit =
          std::clamp(meanOf(shown), wanted / kMostNoise, wanted * kMostNoise) + static_cast<float>(options.dark_share) * mean;
      const float scale = static_cast<float>(options.outlier) * unit;
      reading.importance = mean * mean / (unit * unit) / (1.0f + glm::dot(off, off) / 3.0f / (scale * scale));
    });
    pull_.assign(prior_.size(), 0.0f);
    diagonal_.resize(prior_.size());
    forEach(prior_.size(), [&](size_t t) {
      std::array<float, kShCount> squares{};
      for (const auto& [r, weight] : reads_[t]) {
        const float importance = readings_[r].importance * weight;
        pull_[t] += kPull * static_cast<float>(options.pull) * importance;
        for (int k = 0; k < kShCount; ++k) squares[k] += importance * weight * readings_[r].basis[k] * readings_[r].basis[k];
      }
      pull_[t] += 1e-6f;
      for (int k = 0; k < kShCount; ++k) diagonal_[t][k] = squares[k] + pullOf(k, pull_[t]);
    });
  }

  // Minus the gradient of half the sum of squares, where readings are off by this and texels by that.
  std::vector<LightSh> slope(const std::vector<glm::vec3>& of_readings, const std::vector<LightSh>& of_texels) const {
    std::vector<LightSh> sum(prior_.size());
    forEach(sum.size(), [&](size_t t) {
      for (int k = 0; k < kShCount; ++k) sum[t][k] = pullOf(k, pull_[t]) * of_texels[t][k];
      for (const auto& [r, weight] : reads_[t]) {
        const glm::vec3 share = readings_[r].importance * weight * of_readings[r];
        for (int k = 0; k < kShCount; ++k) sum[t][k] += readings_[r].basis[k] * share;
      }
    });
    return sum;
  }

  glm::dvec3 product(const std::vector<LightSh>& a, const std::vector<LightSh>& b) const {
    glm::dvec3 sum(0.0);
    for (size_t t = 0; t < a.size(); ++t) {
      for (int k = 0; k < kShCount; ++k) sum += glm::dvec3(a[t][k]) * glm::dvec3(b[t][k]);
    }
    return sum;
  }

  static void addTo(std::vector<LightSh>* sum, const glm::dvec3& factor, const std::vector<LightSh>& more) {
    for (size_t t = 0; t < more.size(); ++t) {
      for (int k = 0; k < kShCount; ++k) (*sum)[t][k] += glm::vec3(factor) * more[t][k];
    }
  }

  std::vector<LightSh> preconditioned(std::vector<LightSh> slope) const {
    for (size_t t = 0; t < slope.size(); ++t) {
      for (int k = 0; k < kShCount; ++k) slope[t][k] /= diagonal_[t][k];
    }
    return slope;
  }

  void descend(std::vector<LightSh>* light) const {
    std::vector<glm::vec3> of_readings(readings_.size());
    std::vector<LightSh> of_texels = prior_;
    addTo(&of_texels, glm::dvec3(-1.0), *light);
    forEach(readings_.size(), [&](size_t r) { of_readings[r] = readings_[r].irradiance - shownBy(readings_[r], *light); });
    std::vector<LightSh> residual = slope(of_readings, of_texels), step = preconditioned(residual);
    glm::dvec3 left = product(residual, step);
    const glm::dvec3 first = left;
    for (int i = 0; i < kMaxSteps && glm::any(glm::greaterThan(left, kTolerance * kTolerance * first)); ++i) {
      forEach(readings_.size(), [&](size_t r) { of_readings[r] = shownBy(readings_[r], step); });
      const std::vector<LightSh> curved = slope(of_readings, step);
      const glm::dvec3 length = left / glm::max(product(step, curved), glm::dvec3(1e-300));
      addTo(light, length, step);
      addTo(&residual, -length, curved);
      std::vector<LightSh> next = preconditioned(residual);
      const glm::dvec3 now = product(residual, next);
      addTo(&next, now / glm::max(left, glm::dvec3(1e-300)), step);
      step = std::move(next);
      left = now;
    }
  }

  std::vector<Reading> readings_;
  const std::vector<LightSh> prior_;
  std::vector<std::vector<std::pair<uint32_t, float>>> reads_;  // by texel: readings and their weights
  std::vector<float> pull_;                                     // by texel
  std::vector<std::array<float, kShCount>> diagonal_;
  const int thread_count_;
};

}  // namespace

std::vector<LightSh> solveByNormal(const TexelLookUp& look_up, const std::vector<PositionM>& places_m,
                                   const std::vector<LightSh>& place_light, std::vector<LightSh> light,
                                   const ProbeLightOptions& options, int thread_count) {
  std::vector<Reading> readings;
  for (size_t i = 0; i < places_m.size(); ++i) {
    Random random(mixSeed(options.seed, kNormalStream, i));
    for (int n = 0; n < kNormals; ++n) {
      const double u = random.uniform(), v = random.uniform();
      const glm::vec3 normal = sphereDirection(u, v);
      Reading reading;
      look_up.weightsAt(places_m[i], &normal[0], &reading.texels);
      reading.basis = shBasis(normal[0], normal[1], normal[2]);
      for (int k = 0; k < kShCount; ++k) {
        reading.basis[k] *= kCosineBand[k];
        reading.irradiance += reading.basis[k] * place_light[i][k];
      }
      readings.push_back(reading);
    }
  }
  return NormalSolver(std::move(readings), std::move(light), thread_count).solve(options);
}

}  // namespace nlg
