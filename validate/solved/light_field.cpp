#include "validate/solved/light_field.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "runtime_eval/numbers/random.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr uint32_t kNothing = ~0u;
constexpr int kBounces = 16;
constexpr size_t kOriginCount = 16;  // where rays leave an element
constexpr int kElementsOfALamp = 3;  // at least: crumbs of surface are no lamps
constexpr double kTurn = 6.283185307179586;
constexpr double kGolden = 2.399963229728653;  // the golden angle

// Direction k of `count` on a spiral over the sphere; both shifts in [0, 1) move the whole spiral.
glm::vec3 spiralDirection(int k, int count, double shift, double turn) {
  const double z = 1.0 - 2.0 * (k + shift) / count, radius = std::sqrt(std::max(0.0, 1.0 - z * z));
  const double angle = kGolden * k + kTurn * turn;
  return {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)), static_cast<float>(z)};
}

using SurfaceKey = std::tuple<int, int, int, int>;  // voxel, and which way the surface faces

SurfaceKey surfaceKey(const glm::vec3& at, const glm::vec3& normal, float side_m) {
  int axis = 0;
  for (int a = 1; a < 3; ++a) axis = std::fabs(normal[a]) > std::fabs(normal[axis]) ? a : axis;
  const glm::ivec3 voxel(glm::floor((at + 1e-3f * normal) / side_m));
  return {voxel.x, voxel.y, voxel.z, 2 * axis + (normal[axis] < 0)};
}

class Radiosity {
 public:
  Radiosity(const RayScene& rays, const Scene& scene, const LightOptions& options)
      : rays_(rays), scene_(scene), options_(options) {}

  // The element that a ray meets first, made when it is new.
  uint32_t elementAlong(const glm::vec3& origin, const glm::vec3& direction) {
    const std::optional<SurfaceHit> hit = rays_.firstHit(origin, direction);
    if (!hit) return kNothing;
    const glm::vec3 at = origin + hit->distance * direction;
    const auto [entry, is_new] =
        element_of_.emplace(surfaceKey(at, hit->normal, options_.element_m), static_cast<uint32_t>(elements_.size()));
    if (is_new) {
      const SurfaceKey patch = surfaceKey(at, hit->normal, static_cast<float>(options_.lamp_m));
      const uint32_t lamp = lamp_of_.emplace(patch, static_cast<uint32_t>(lamp_of_.size())).first->second;
      elements_.push_back({{}, hit->normal, scene_.materials[hit->material].base_color.g, lamp});
    }
    Element& element = elements_[entry->second];
    if (element.origins.size() < kOriginCount) element.origins.push_back(at + 1e-3f * hit->normal);
    return entry->second;
  }

  // Elements x lamps: what each element sends back when one lamp at a time shines with 1; the lamp's own light is left out.
  std::vector<float> reflected(const std::vector<uint32_t>& lamps) {
    std::vector<std::vector<uint32_t>> seen_from;
    for (uint32_t e = 0; e < elements_.size(); ++e) seen_from.push_back(raysFrom(e));  // may find further elements
    const size_t lamp_count = lamps.size();
    const auto shines = [&](uint32_t e, size_t l) { return elements_[e].lamp == lamps[l] ? 1.0f : 0.0f; };
    std::vector<float> sent(elements_.size() * lamp_count), next;
    for (int bounce = 0; bounce < kBounces; ++bounce) {
      next.assign(sent.size(), 0.0f);
      for (uint32_t e = 0; e < elements_.size(); ++e) {
        float* row = &next[e * lamp_count];
        for (const uint32_t other : seen_from[e]) {
          for (size_t l = 0; l < lamp_count; ++l) row[l] += sent[other * lamp_count + l] + shines(other, l);
        }
        const float share = elements_[e].albedo / static_cast<float>(options_.rays_per_element);
        for (size_t l = 0; l < lamp_count; ++l) row[l] *= share;
      }
      sent.swap(next);
    }
    return sent;
  }

  // Patches that are large enough, in a fixed random order.
  std::vector<uint32_t> lamps() const {
    std::vector<int> size(lamp_of_.size());
    for (const Element& element : elements_) ++size[element.lamp];
    std::vector<uint32_t> order;
    for (uint32_t l = 0; l < size.size(); ++l) {
      if (size[l] >= kElementsOfALamp) order.push_back(l);
    }
    Random random(mixSeed(options_.seed, 1));
    for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(static_cast<uint32_t>(i))]);
    return order;
  }

 private:
  struct Element {
    std::vector<glm::vec3> origins;
    glm::vec3 normal;
    float albedo;
    uint32_t lamp;
  };

  // Elements that cosine-distributed rays meet; a copy of the element is taken because the list may grow meanwhile.
  std::vector<uint32_t> raysFrom(uint32_t index) {
    const Element element = elements_[index];
    Random random(mixSeed(options_.seed, 2, index));
    const double shift = random.uniform(), turn = random.uniform();
    std::vector<uint32_t> met;
    for (int k = 0; k < options_.rays_per_element; ++k) {
      // a point of the unit sphere around the normal's tip is cosine-distributed
      const glm::vec3 tip = element.normal + 0.999f * spiralDirection(k, options_.rays_per_element, shift, turn);
      const uint32_t other = elementAlong(element.origins[k % element.origins.size()], glm::normalize(tip));
      if (other != kNothing) met.push_back(other);
    }
    return met;
  }

  const RayScene& rays_;
  const Scene& scene_;
  const LightOptions& options_;
  std::map<SurfaceKey, uint32_t> element_of_, lamp_of_;
  std::vector<Element> elements_;
};

// Every ray of every point, the same each time it is asked for.
template <class Visit>
void forEachRay(const LightOptions& options, uint32_t point, const Visit& visit) {
  Random random(mixSeed(options.seed, 3, point));
  const double shift = random.uniform(), turn = random.uniform();
  for (int k = 0; k < options.rays_per_point; ++k) visit(k, spiralDirection(k, options.rays_per_point, shift, turn));
}

void normalise(Signals& signals) {
  for (int lamp = 0; lamp < signals.count / kAxisCount; ++lamp) {
    double sum = 0.0;
    const size_t point_count = signals.value.size() / signals.count;
    const auto forEachValue = [&](const auto& visit) {
      for (size_t i = 0; i < point_count; ++i) {
        for (int axis = 0; axis < kAxisCount; ++axis) visit(signals.row(i)[lamp * kAxisCount + axis]);
      }
    };
    forEachValue([&](float value) { sum += double{value} * value; });
    if (sum == 0.0) continue;
    const auto scale = static_cast<float>(1.0 / std::sqrt(sum / static_cast<double>(point_count * kAxisCount)));
    forEachValue([&](float& value) { value *= scale; });
  }
}

// Irradiance of `lamp_count` lamps from number `first` on.
Signals gather(const LightOptions& options, const std::vector<uint32_t>& met, const std::vector<float>& sent, size_t all_lamps,
               size_t first, size_t lamp_count) {
  Signals signals;
  signals.count = static_cast<int>(lamp_count) * kAxisCount;
  const size_t point_count = met.size() / options.rays_per_point;
  signals.value.assign(point_count * signals.count, 0.0f);
  std::vector<float> sum(lamp_count * kAxisCount);
  const float share = 4.0f / static_cast<float>(options.rays_per_point);  // white light from everywhere gives 1
  for (uint32_t i = 0; i < point_count; ++i) {
    std::fill(sum.begin(), sum.end(), 0.0f);
    forEachRay(options, i, [&](int k, const glm::vec3& direction) {
      const uint32_t element = met[size_t(i) * options.rays_per_point + k];
      if (element == kNothing) return;
      const float* radiance = &sent[element * all_lamps + first];
      for (int axis = 0; axis < 3; ++axis) {
        const float cosine = std::fabs(direction[axis]) * share;
        float* into = &sum[(2 * axis + (direction[axis] < 0)) * lamp_count];
        for (size_t l = 0; l < lamp_count; ++l) into[l] += cosine * radiance[l];
      }
    });
    for (size_t l = 0; l < lamp_count; ++l) {
      for (int axis = 0; axis < kAxisCount; ++axis) signals.row(i)[l * kAxisCount + axis] = sum[axis * lamp_count + l];
    }
  }
  normalise(signals);
  return signals;
}

}  // namespace

LightField gatherLight(const RayScene& rays, const Scene& scene, const SamplePoints& points, const LightOptions& options) {
  Radiosity radiosity(rays, scene, options);
  std::vector<uint32_t> met(points.count() * options.rays_per_point);
  for (uint32_t i = 0; i < points.count(); ++i) {
    forEachRay(options, i, [&](int k, const glm::vec3& direction) {
      met[size_t(i) * options.rays_per_point + k] = radiosity.elementAlong(points.position_m[i], direction);
    });
  }
  std::vector<uint32_t> lamps = radiosity.lamps();
  if (lamps.size() < 2) {
    throw InputError(scene.id, "surfaces", "at least two patches that can be lamps", std::to_string(lamps.size()));
  }
  const size_t test_count = std::min<size_t>(options.test_lamps, lamps.size() / 2);
  lamps.resize(std::min<size_t>(lamps.size(), test_count + options.fit_lamps));
  const std::vector<float> sent = radiosity.reflected(lamps);
  LightField field;
  field.test = gather(options, met, sent, lamps.size(), 0, test_count);
  field.fit = gather(options, met, sent, lamps.size(), test_count, lamps.size() - test_count);
  return field;
}

}  // namespace nlg
