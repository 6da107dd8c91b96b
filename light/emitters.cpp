#include "light/emitters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "runtime_eval/numbers/random.h"
#include "scene/model/scene_light.h"
#include "scene/model/surface_look.h"

namespace nlg {
namespace {

constexpr uint32_t kNone = ~0u;

glm::vec3 crossOf(const Scene& scene, uint32_t triangle) {
  const glm::uvec3& t = scene.triangles[triangle];
  return glm::cross(scene.positions[t.y] - scene.positions[t.x], scene.positions[t.z] - scene.positions[t.x]);
}

// Corners of one of side² parts of a triangle, as weights of its second and third corner.
std::array<glm::vec2, 3> cornersOfPart(int side, int part) {
  // rows of constant u hold 2 (side - row) - 1 parts
  int row = 0, before = 0;
  while (part - before >= 2 * (side - row) - 1) before += 2 * (side - row++) - 1;
  const int column = (part - before) / 2;
  const auto at = [&](int u, int v) { return glm::vec2(row + u, column + v) / static_cast<float>(side); };
  if ((part - before) % 2 == 0) return {at(0, 0), at(1, 0), at(0, 1)};
  return {at(1, 1), at(0, 1), at(1, 0)};
}

int partAt(int side, float u, float v) {
  if (side == 1) return 0;
  const auto cell = [&](float w, int count) { return std::clamp(static_cast<int>(w * static_cast<float>(side)), 0, count - 1); };
  const int row = cell(u, side), column = cell(v, side - row);
  const float across = (u + v) * static_cast<float>(side) - static_cast<float>(row + column);
  const bool is_upside_down = across > 1.0f && column < side - row - 1;
  return side * side - (side - row) * (side - row) + 2 * column + (is_upside_down ? 1 : 0);
}

glm::vec3 pointOf(const Scene& scene, uint32_t triangle, const glm::vec2& at) {
  const glm::uvec3& t = scene.triangles[triangle];
  return scene.positions[t.x] * (1.0f - at.x - at.y) + scene.positions[t.y] * at.x + scene.positions[t.z] * at.y;
}

constexpr double kTexelsOfPatch = 2.0;       // along its side
constexpr uint64_t kMostPatches = 1u << 20;  // of images; beyond, patches are larger
// Of a patch's side: its mean luminance is over so many squared. Two a texel: a texel between samples would never be drawn.
constexpr double kSamplesOfTexel = 2.0;
constexpr double kFewestSamples = 4.0, kMostSamples = 16.0;

// Of the image that a triangle shines by, along a side of it: the root of how many cover the square that it is half of. 0 without.
double texelsOfSide(const Scene& scene, uint32_t triangle) {
  const Material& material = materialOf(scene, triangle);
  const bool is_by_emission = material.emissive_image.isThere();
  const TextureUse& use = is_by_emission ? material.emissive_image : material.base_image;
  if (!use.isThere()) return 0.0;
  const TextureImage& image = scene.images[static_cast<size_t>(use.image)];
  const std::vector<glm::vec2>& places = is_by_emission ? scene.emissive_places : scene.base_places;
  const glm::uvec3& t = scene.triangles[triangle];
  const glm::vec2 size(image.width, image.height);
  const glm::vec2 a = (places[t.y] - places[t.x]) * size, b = (places[t.z] - places[t.x]) * size;
  return std::sqrt(std::fabs(static_cast<double>(a.x) * b.y - static_cast<double>(a.y) * b.x));
}

// How many patches its texels ask for along a side of a triangle.
int wantedSide(double texels) {
  return static_cast<int>(std::clamp(std::ceil(texels / kTexelsOfPatch), 1.0, static_cast<double>(Emitters::kMostSide)));
}

int samplesOfSide(double texels, int side) {
  return static_cast<int>(std::clamp(std::ceil(kSamplesOfTexel * texels / side), kFewestSamples, kMostSamples));
}

// Whether the emission of points of a triangle differs.
bool isByImage(const Material& material) {
  return material.emissive_image.isThere() || material.transmissive != Transmissive::none;
}

float meanLuminance(const Scene& scene, uint32_t triangle, const std::array<glm::vec2, 3>& corners, int samples) {
  float sum = 0.0f;
  for (int part = 0; part < samples * samples; ++part) {
    const std::array<glm::vec2, 3> small = cornersOfPart(samples, part);
    const glm::vec2 within = (small[0] + small[1] + small[2]) / 3.0f;
    const glm::vec2 at = corners[0] + within.x * (corners[1] - corners[0]) + within.y * (corners[2] - corners[0]);
    sum += luminance(emissionAt(scene, triangle, at.x, at.y));
  }
  return sum / static_cast<float>(samples * samples);
}

// Halves the widest range again and again: neighbours stay together.
// middles   by patch
std::vector<std::vector<uint32_t>> clustersOf(const std::vector<glm::vec3>& middles) {
  struct Range {
    std::vector<uint32_t> patches;
    glm::vec3 size{0.0f};
  };
  const auto measured = [&](std::vector<uint32_t> members) {
    glm::vec3 low = middles[members.front()], high = low;
    for (const uint32_t p : members) {
      low = glm::min(low, middles[p]);
      high = glm::max(high, middles[p]);
    }
    return Range{std::move(members), high - low};
  };
  const auto width = [](const Range& range) { return std::max({range.size.x, range.size.y, range.size.z}); };
  std::vector<Range> ranges;
  std::vector<uint32_t> all(middles.size());
  std::iota(all.begin(), all.end(), 0u);
  ranges.push_back(measured(std::move(all)));
  while (ranges.size() < Emitters::kMostClusters) {
    const auto widest =
        std::max_element(ranges.begin(), ranges.end(), [&](const Range& a, const Range& b) { return width(a) < width(b); });
    // all that is left stands in one place
    if (!(width(*widest) > 0.0f)) break;
    const int axis = widest->size.x == width(*widest) ? 0 : widest->size.y == width(*widest) ? 1 : 2;
    // at the median, so that clusters draw among about as many patches
    std::vector<uint32_t> members = std::move(widest->patches);
    const auto half = members.begin() + static_cast<ptrdiff_t>(members.size() / 2);
    std::nth_element(members.begin(), half, members.end(), [&](uint32_t a, uint32_t b) {
      const float at_a = middles[a][axis], at_b = middles[b][axis];
      return at_a != at_b ? at_a < at_b : a < b;
    });
    *widest = measured({members.begin(), half});
    ranges.push_back(measured({half, members.end()}));
  }
  // in the order of patches, whatever nth_element left
  std::vector<std::vector<uint32_t>> clusters;
  for (Range& range : ranges) {
    std::sort(range.patches.begin(), range.patches.end());
    clusters.push_back(std::move(range.patches));
  }
  return clusters;
}

// The lower of the two texels around a place, and how far the place is on the way to the other.
void splitPlace(float place, int side, int* low, float* share) {
  const float texel = std::clamp(place * static_cast<float>(side) - 0.5f, 0.0f, static_cast<float>(side - 1));
  *low = std::min(static_cast<int>(texel), side - 2);
  *share = texel - static_cast<float>(*low);
}

}  // namespace

void Emitters::cutIntoPatches() {
  std::vector<std::pair<uint32_t, double>> wanted;  // triangle and texels of its side
  uint64_t by_image = 0;
  // what shines by an image is cut as finely as its texels; all else is one patch
  for (uint32_t t = 0; t < scene_.triangles.size(); ++t) {
    const Material& material = materialOf(scene_, t);
    if (!(luminance(material.emissive) * glm::length(crossOf(scene_, t)) > 0.0f)) continue;
    const double texels = isByImage(material) ? texelsOfSide(scene_, t) : 0.0;
    wanted.emplace_back(t, texels);
    by_image += static_cast<uint64_t>(wantedSide(texels) * wantedSide(texels));
  }
  if (wanted.empty()) return;
  // beyond the most patches all sides shrink alike
  const double shrink = std::min(1.0, std::sqrt(static_cast<double>(kMostPatches) / static_cast<double>(by_image)));
  shining_of_.assign(scene_.triangles.size(), kNone);
  for (const auto& [t, texels] : wanted) {
    const Material& material = materialOf(scene_, t);
    const int side = std::max(1, static_cast<int>(wantedSide(texels) * shrink)), samples = samplesOfSide(texels, side);
    shining_of_[t] = static_cast<uint32_t>(shining_.size());
    shining_.push_back({static_cast<uint32_t>(patch_at_.size()), static_cast<uint16_t>(side)});
    // a patch without light is never drawn
    for (int part = 0; part < side * side; ++part) {
      const float shine =
          isByImage(material) ? meanLuminance(scene_, t, cornersOfPart(side, part), samples) : luminance(material.emissive);
      patch_at_.push_back(shine > 0.0f ? static_cast<uint32_t>(patches_.size()) : kNone);
      if (shine > 0.0f) patches_.push_back({t, static_cast<uint16_t>(side), static_cast<uint16_t>(part), shine});
    }
  }
}

Emitters::Emitters(const Scene& scene) : scene_(scene) {
  cutIntoPatches();
  if (patches_.empty()) return;
  const auto cornersOf = [&](const Patch& patch) {
    std::array<glm::vec3, 3> corners;
    const std::array<glm::vec2, 3> weights = cornersOfPart(patch.side, patch.part);
    for (size_t k = 0; k < 3; ++k) corners[k] = pointOf(scene, patch.triangle, weights[k]);
    return corners;
  };
  std::vector<glm::vec3> middles;
  for (const Patch& patch : patches_) {
    const std::array<glm::vec3, 3> corners = cornersOf(patch);
    middles.push_back((corners[0] + corners[1] + corners[2]) / 3.0f);
  }
  // patches of a cluster side by side, with running sums of power: a point is drawn by two binary searches
  std::vector<Patch> by_cluster;
  std::vector<uint32_t> place_of(patches_.size());  // in by_cluster
  for (const std::vector<uint32_t>& members : clustersOf(middles)) {
    Cluster cluster;
    cluster.first = static_cast<uint32_t>(by_cluster.size());
    cluster.count = static_cast<uint32_t>(members.size());
    for (const uint32_t p : members) {
      const Patch& patch = patches_[p];
      cluster.power +=
          0.5f * glm::length(crossOf(scene, patch.triangle)) * patch.luminance / static_cast<float>(patch.side * patch.side);
      cluster.middle += middles[p] / static_cast<float>(members.size());
      cluster_of_.push_back(static_cast<uint32_t>(clusters_.size()));
      place_of[p] = static_cast<uint32_t>(by_cluster.size());
      by_cluster.push_back(patch);
      sums_.push_back(cluster.power);
    }
    // within its radius a cluster counts as no nearer, so that its share stays finite
    for (const uint32_t p : members) {
      for (const glm::vec3& corner : cornersOf(patches_[p])) {
        const glm::vec3 way = corner - cluster.middle;
        cluster.radius_squared = std::max(cluster.radius_squared, glm::dot(way, way));
      }
    }
    clusters_.push_back(cluster);
  }
  patches_ = std::move(by_cluster);
  // parts of triangles name patches by their new places
  for (uint32_t& patch : patch_at_) {
    if (patch != kNone) patch = place_of[patch];
  }
}

float Emitters::reach(const Cluster& cluster, const glm::vec3& from) {
  const glm::vec3 way = from - cluster.middle;
  return cluster.power / std::max(glm::dot(way, way), cluster.radius_squared);
}

Emitters::Draws::Draws(const Emitters& emitters, const glm::vec3& from) : emitters_(emitters) {
  float sum = 0.0f;
  for (size_t c = 0; c < emitters.clusters_.size(); ++c) sums_[c] = sum += reach(emitters.clusters_[c], from);
}

float Emitters::Draws::chance(size_t cluster) const {
  const float before = cluster > 0 ? sums_[cluster - 1] : 0.0f;
  return (sums_[cluster] - before) / sums_[emitters_.clusters_.size() - 1];
}

EmitterPoint Emitters::Draws::draw(double u, Random& random) const {
  const auto indexIn = [](const float* first, size_t count, float at) {
    return std::min<size_t>(static_cast<size_t>(std::upper_bound(first, first + count, at) - first), count - 1);
  };
  const size_t count = emitters_.clusters_.size();
  const float reached = static_cast<float>(u) * sums_[count - 1];
  const size_t chosen = indexIn(sums_.data(), count, reached);
  const Cluster& cluster = emitters_.clusters_[chosen];
  // where u lies within the cluster's part is as evenly spread as u itself
  const float before = chosen > 0 ? sums_[chosen - 1] : 0.0f;
  const float within = std::clamp((reached - before) / std::max(sums_[chosen] - before, 1e-30f), 0.0f, 1.0f);
  const size_t index = indexIn(&emitters_.sums_[cluster.first], cluster.count, within * cluster.power);
  const Patch& patch = emitters_.patches_[cluster.first + index];
  auto a = static_cast<float>(random.uniform()), b = static_cast<float>(random.uniform());
  if (a + b > 1.0f) {
    a = 1.0f - a;
    b = 1.0f - b;
  }
  const std::array<glm::vec2, 3> corners = cornersOfPart(patch.side, patch.part);
  const glm::vec2 at = corners[0] + a * (corners[1] - corners[0]) + b * (corners[2] - corners[0]);
  return {patch.triangle, pointOf(emitters_.scene_, patch.triangle, at), at.x, at.y, density(chosen, patch.luminance)};
}

float Emitters::Draws::density(size_t cluster, float luminance) const {
  return chance(cluster) * luminance / emitters_.clusters_[cluster].power;
}

float Emitters::Draws::areaDensity(uint32_t triangle, float u, float v) const {
  if (emitters_.empty() || emitters_.shining_of_[triangle] == kNone) return 0.0f;
  const Shining& shining = emitters_.shining_[emitters_.shining_of_[triangle]];
  const uint32_t patch = emitters_.patch_at_[shining.first_part + static_cast<uint32_t>(partAt(shining.side, u, v))];
  return patch == kNone ? 0.0f : density(emitters_.cluster_of_[patch], emitters_.patches_[patch].luminance);
}

glm::vec3 bakedLight(const Scene& scene, uint32_t triangle, float u, float v) {
  const BakedLight& baked = scene.light.baked;
  const glm::uvec3& t = scene.triangles[triangle];
  const float w = 1.0f - u - v;
  const int32_t page = baked.triangle_page[triangle];
  if (page == BakedLight::kByVertex)
    return baked.vertex_light[t.x] * w + baked.vertex_light[t.y] * u + baked.vertex_light[t.z] * v;
  const glm::vec2 place = baked.vertex_place[t.x] * w + baked.vertex_place[t.y] * u + baked.vertex_place[t.z] * v;
  const int side = baked.page_side;
  int x, y;
  float sx, sy;
  splitPlace(place.x, side, &x, &sx);
  splitPlace(place.y, side, &y, &sy);
  const glm::vec3* row = &baked.texels[static_cast<size_t>(page) * side * side] + static_cast<size_t>(y) * side + x;
  return (row[0] * (1.0f - sx) + row[1] * sx) * (1.0f - sy) + (row[side] * (1.0f - sx) + row[side + 1] * sx) * sy;
}

}  // namespace nlg
