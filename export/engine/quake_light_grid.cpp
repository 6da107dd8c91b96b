#include "export/engine/quake_light_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <glm/gtc/type_ptr.hpp>

#include "scene/archive/pk3_archive.h"
#include "scene/quake/bsp_entities.h"
#include "scene/quake/bsp_file.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kUnitM = 0.0254;
constexpr size_t kLumpBytes = 8, kRawBytes = 24;  // a point
constexpr size_t kLumpGrid = 15, kHeaderBytes = 8, kEntryBytes = 8;
constexpr float kAmbientScale = 0.6f, kLeastCodes = 32.0f, kMostCodes = 255.0f;
constexpr float kStoredShift = 4.0f;                                              // codes of a file become so many
constexpr float kCode = std::numbers::pi_v<float> / kMostCodes;                   // irradiance of a shown one
constexpr float kMeanOfLobe = 0.25f, kLobeVariance = 1.0f / 6.0f - 1.0f / 16.0f;  // of max(0, cos) over all directions
constexpr float kMeanUnit = 0.886226925f;                                         // irradiance of a first coefficient of 1
const float kDirectedUnit = kMeanUnit * kCosineBand[1] / kCosineBand[0] / std::sqrt(kLobeVariance);

struct Lump {
  size_t offset, size;
};
Lump gridLump(const std::string& bytes) {
  const size_t entry = kHeaderBytes + kEntryBytes * kLumpGrid;
  return {numberAt(bytes, entry, 4), numberAt(bytes, entry + 4, 4)};
}

// Of the level's own axes, z up: as engines count them.
struct GridPoints {
  std::array<float, 3> first, step;
  std::array<uint32_t, 3> count;
  size_t points() const { return size_t{count[0]} * count[1] * count[2]; }
};

GridPoints pointsOf(const std::string& path, const BspFile& file) {
  GridPoints grid{{}, {64.0f, 64.0f, 128.0f}, {}};
  for (const BspEntity& entity : readEntities(path, file.entities)) {
    if (textOf(entity, "classname") != "worldspawn") continue;
    if (const auto size = threeNumbers(textOf(entity, "gridsize")); size && glm::all(glm::greaterThan(*size, glm::dvec3(0.0))))
      grid.step = {static_cast<float>(size->x), static_cast<float>(size->y), static_cast<float>(size->z)};
  }
  for (int axis = 0; axis < 3; ++axis) {
    const float step = grid.step[axis], low = step * std::ceil(file.models[0].min[axis] / step);
    grid.first[axis] = low;
    grid.count[axis] =
        static_cast<uint32_t>(std::max(0.0f, (step * std::floor(file.models[0].max[axis] / step) - low) / step + 1.0f));
  }
  return grid;
}

// (x, y, z) of the level is (x, z, -y) of the scene.
LightBox boxOf(const GridPoints& grid) {
  LightBox box;
  constexpr std::array<size_t, 3> kFrom = {0, 2, 1};
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t from = kFrom[axis];
    const double low = grid.first[from] - 0.5 * grid.step[from], high = low + double{grid.step[from]} * grid.count[from];
    box.low_m[axis] = kUnitM * (axis == 2 ? -high : low);
    box.high_m[axis] = kUnitM * (axis == 2 ? -low : high);
    box.texel_count[axis] = grid.count[from];
  }
  return box;
}

// Of a texel, the number of its point in the file.
size_t pointOf(const LightBox& box, size_t texel) {
  const size_t nx = box.texel_count[0], ny = box.texel_count[1], nz = box.texel_count[2];
  const size_t x = texel % nx, y = texel / nx % ny, z = texel / (nx * ny);
  return x + nx * (nz - 1 - z + nz * y);
}

glm::vec3 storedCodes(const glm::vec3& shown) {
  const glm::vec3 codes = glm::max(shown, glm::vec3(0.0f));
  return codes * std::min(1.0f, kMostCodes / std::max({codes.r, codes.g, codes.b, 1e-6f})) / kStoredShift;
}

// Ambient and directed light in codes of a file.
std::pair<glm::vec3, glm::vec3> storedCodes(const LightSh& mean_and_directed) {
  const glm::vec3 mean = glm::max(kMeanUnit * mean_and_directed[0], glm::vec3(0.0f)) / kCode;
  // no more is directed than what the engine adds by itself leaves: the mean stays
  const glm::vec3 most = glm::max(mean - kLeastCodes, glm::vec3(0.0f)) / kMeanOfLobe;
  const glm::vec3 directed = glm::clamp(kDirectedUnit * mean_and_directed[1] / kCode, glm::vec3(0.0f), most);
  const glm::vec3 ambient = (mean - kMeanOfLobe * directed - kLeastCodes) / kAmbientScale;
  // a point without any light would be left out: in the dark it holds half a code
  return {glm::max(storedCodes(ambient), glm::vec3(0.5f)), storedCodes(directed)};
}

// As engines shift what a file holds; a colour that is too bright keeps its hue.
glm::vec3 shownCodes(glm::vec3 stored) {
  stored *= kStoredShift;
  return stored * std::min(1.0f, kMostCodes / std::max({stored.r, stored.g, stored.b, 1e-6f}));
}

// Two angles of a direction of the level, 256 a turn: from z, and around it.
std::array<uint8_t, 2> anglesOf(const glm::vec3& direction) {
  const glm::vec3 level(direction.x, -direction.z, direction.y);
  constexpr float kTurn = 128.0f / std::numbers::pi_v<float>;
  const auto byteOf = [](float angle) { return static_cast<uint8_t>(static_cast<int>(std::lround(angle * kTurn)) & 255); };
  return {byteOf(std::acos(std::clamp(level.z, -1.0f, 1.0f))), byteOf(std::atan2(level.y, level.x))};
}

glm::vec3 directionOf(uint8_t from_z, uint8_t around_z) {
  constexpr float kAngle = std::numbers::pi_v<float> / 128.0f;
  const float lng = kAngle * from_z, lat = kAngle * around_z;
  return {std::cos(lat) * std::sin(lng), std::cos(lng), -std::sin(lat) * std::sin(lng)};
}

}  // namespace

QuakeLevel readQuakeLevel(const std::string& request) {
  QuakeLevel level;
  const size_t colon = request.rfind(':');
  if (extensionOf(request) == ".bsp") {
    level.name = std::filesystem::path(request).stem().string();
    level.bytes = readFile(request);
  } else if (colon != std::string::npos) {
    const Pk3Archives archives(request.substr(0, colon));
    level.name = lowerCase(request.substr(colon + 1));
    const std::string entry = "maps/" + level.name + ".bsp";
    level.bytes = archives.read(entry, archives.sizeOf(entry));
  } else {
    throw InputError(request, "scene", "a level of a Quake III-family game: FILE.bsp, or PATH:MAP in .pk3 archives",
                     "a file that ends in '" + extensionOf(request) + "'");
  }
  const GridPoints grid = pointsOf(request, parseBsp(request, level.bytes));
  const Lump lump = gridLump(level.bytes);
  if (grid.points() == 0 || lump.size != kLumpBytes * grid.points())
    throw InputError(request, "lump 15", "a light grid of " + std::to_string(grid.points()) + " points",
                     std::to_string(lump.size) + " bytes");
  level.box = boxOf(grid);
  return level;
}

glm::vec3 unitOr(const glm::vec3& vector, const glm::vec3& other) {
  const float length = glm::length(vector);
  return length > 0.0f ? vector / length : other;
}

glm::vec3 mainDirection(const LightSh& light) {
  glm::vec3 sum(0.0f);
  for (int c = 0; c < kShChannels; ++c) sum += glm::vec3(light[3][c], light[1][c], light[2][c]);
  return unitOr(sum, {0.0f, 1.0f, 0.0f});
}

LightSh meanAndDirected(const LightSh& light, const glm::vec3& direction) {
  // least squares over all normals: irradiance against 1 and max(0, normal · direction)
  LightSh bands = light;
  for (int k = 0; k < kShCount; ++k) bands[k] *= kCosineBand[k];
  const glm::vec3 mean = kMeanUnit * light[0];
  const glm::vec3 by_lobe = irradiance(bands, direction) / (4.0f * std::numbers::pi_v<float>);
  LightSh result{};
  result[0] = light[0];
  result[1] = glm::max((by_lobe - kMeanOfLobe * mean) / kLobeVariance, glm::vec3(0.0f)) / kDirectedUnit;
  return result;
}

QuakeGridBytes quakeGridBytes(const QuakeLevel& level, const std::vector<LightSh>& mean_and_directed,
                              const std::vector<glm::vec3>& directions, const std::vector<uint8_t>& is_made) {
  const size_t count = level.box.texelCount();
  const std::string own = lightGridOf(level);
  QuakeGridBytes bytes{std::string(kRawBytes * count, '\0'), std::string(kLumpBytes * count, '\0')};
  for (size_t texel = 0; texel < count; ++texel) {
    const size_t point = pointOf(level.box, texel);
    std::string raw, lump;
    const auto hold = [&](float code) {
      appendNumber(std::bit_cast<uint32_t>(code), 4, &raw);
      appendNumber(static_cast<uint64_t>(std::lround(code)), 1, &lump);
    };
    if (!is_made[texel]) {
      for (size_t i = 0; i < 6; ++i) hold(static_cast<float>(numberAt(own, kLumpBytes * point + i, 1)));
      lump += own.substr(kLumpBytes * point + 6, 2);
    } else {
      const auto [ambient, directed] = storedCodes(mean_and_directed[texel]);
      for (const glm::vec3& colour : {ambient, directed}) {
        for (int c = 0; c < kShChannels; ++c) hold(colour[c]);
      }
      for (const uint8_t angle : anglesOf(directions[texel])) appendNumber(angle, 1, &lump);
    }
    bytes.raw.replace(kRawBytes * point, kRawBytes, raw);
    bytes.lump.replace(kLumpBytes * point, kLumpBytes, lump);
  }
  return bytes;
}

std::string lightGridOf(const QuakeLevel& level) {
  const Lump lump = gridLump(level.bytes);
  return level.bytes.substr(lump.offset, lump.size);
}

std::string withLightGrid(const QuakeLevel& level, const std::string& grid) {
  const Lump lump = gridLump(level.bytes);
  NLG_CHECK(grid.size(), ==, lump.size);
  std::string bytes = level.bytes;
  return bytes.replace(lump.offset, lump.size, grid);
}

QuakeGrid::QuakeGrid(const QuakeLevel& level, const QuakeGridBytes& bytes) {
  const size_t count = level.box.texelCount();
  look_up_ = {level.box, 0.0, std::vector<uint8_t>(count)};
  points_.resize(count);
  for (size_t texel = 0; texel < count; ++texel) {
    const size_t point = pointOf(level.box, texel);
    std::array<float, 6> codes;
    for (size_t i = 0; i < codes.size(); ++i) {
      codes[i] = bytes.raw.empty()
                     ? static_cast<float>(numberAt(bytes.lump, kLumpBytes * point + i, 1))
                     : std::bit_cast<float>(static_cast<uint32_t>(numberAt(bytes.raw, kRawBytes * point + 4 * i, 4)));
      look_up_.is_valid[texel] |= codes[i] > 0.0f;
    }
    const auto angle = [&](size_t i) { return static_cast<uint8_t>(numberAt(bytes.lump, kLumpBytes * point + i, 1)); };
    points_[texel] = {shownCodes({codes[0], codes[1], codes[2]}), shownCodes({codes[3], codes[4], codes[5]}),
                      directionOf(angle(6), angle(7))};
  }
}

QuakeGrid::Point QuakeGrid::blended(const ProbeWeights& weights) const {
  Point sum;
  for (int i = 0; i < weights.count; ++i) {
    const Point& point = points_[weights.probe[i]];
    sum.ambient += weights.weight[i] * point.ambient;
    sum.directed += weights.weight[i] * point.directed;
    sum.direction += weights.weight[i] * point.direction;
  }
  return {kAmbientScale * sum.ambient + kLeastCodes, sum.directed, unitOr(sum.direction, glm::vec3(0.0f))};
}

std::array<float, kShChannels> QuakeGrid::shown(const ProbeWeights& weights, const float* normal_3) const {
  const Point point = blended(weights);
  const float lobe = std::max(0.0f, glm::dot(point.direction, glm::make_vec3(normal_3)));
  const glm::vec3 shown = kCode * (point.ambient + lobe * point.directed);
  return {shown.r, shown.g, shown.b};
}

LightSh QuakeGrid::light(const ProbeWeights& weights) const {
  const Point point = blended(weights);
  const std::array<float, kShCount> basis = shBasis(point.direction.x, point.direction.y, point.direction.z);
  LightSh light{};
  for (int k = 0; k < kShCount; ++k) light[k] = basis[k] * kCode * point.directed;
  light[0] += kCode / kMeanUnit * point.ambient;
  return light;
}

EngineIrradiance quakeIrradiance(const QuakeLevel& level, const QuakeGridBytes& bytes) {
  return [grid = QuakeGrid(level, bytes)](const PositionM& position_m, const float* normal_3) {
    ProbeWeights weights;
    grid.lookUp().weightsAt(position_m, normal_3, &weights);
    return grid.shown(weights, normal_3);
  };
}

CompiledLight::CompiledLight(const QuakeLevel& level, const RayScene& rays, const glm::dvec3& origin_m)
    : grid_(level, {{}, lightGridOf(level)}), rays_(rays), origin_m_(origin_m) {}

void CompiledLight::weightsAt(const glm::dvec3& position_m, ProbeWeights* weights) const {
  // less is an answer from far away
  constexpr float kLeastSeen = 0.05f;
  constexpr double kBesideM = 0.15;
  constexpr float kUp[3] = {0.0f, 1.0f, 0.0f};
  const LightBox& box = grid_.lookUp().box;
  const glm::dvec3 world = position_m + origin_m_;
  ProbeWeights all;
  grid_.lookUp().weightsAt({world.x, world.y, world.z}, kUp, &all);
  weights->count = 0;
  float seen = 0.0f;
  for (int i = 0; i < all.count; ++i) {
    const PositionM at = box.texelCentre(all.probe[i]);
    const glm::dvec3 way = glm::dvec3(at[0], at[1], at[2]) - origin_m_ - position_m;
    const double left = std::max(0.0, 1.0 - kBesideM / std::max(kBesideM, glm::length(way)));
    if (rays_.isBlocked(glm::vec3(position_m), glm::vec3(position_m + left * way))) continue;
    weights->probe[weights->count] = all.probe[i];
    weights->weight[weights->count++] = all.weight[i];
    seen += all.weight[i];
  }
  if (seen < kLeastSeen) weights->count = 0;
  for (int i = 0; i < weights->count; ++i) weights->weight[i] /= seen;
}

}  // namespace nlg
