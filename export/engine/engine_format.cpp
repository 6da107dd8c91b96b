#include "export/engine/engine_format.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <nlohmann/json.hpp>

#include "export/shader/shader_export.h"
#include "runtime_eval/numbers/random.h"
#include "runtime_eval/shader_grid/nlg_light_grid.h"
#include "tool/error.h"

namespace nlg {
namespace {

// KTX 2.0 files of one 3-D texture of RGBA16F: one level, no supercompression (registry.khronos.org/KTX/specs/2.0).

constexpr std::string_view kIdentifier("\xabKTX 20\xbb\r\n\x1a\n", 12);
constexpr size_t kWord = sizeof(uint32_t), kHeaderBytes = 12 + 9 * kWord + 4 * kWord + 16, kLevelBytes = 24, kTexelBytes = 8;

// Khronos Data Format 1.3: one basic descriptor block, of a sample a channel.
std::string dataFormatDescriptor() {
  constexpr uint32_t kBlockBytes = 24, kSampleBytes = 16, kVersion = 2, kColorModelRgb = 1, kPrimariesBt709 = 1,
                     kTransferLinear = 1, kSigned = 0x40, kFloat = 0x80;
  constexpr uint32_t kChannels[] = {0, 1, 2, 15};  // red, green, blue, alpha
  constexpr size_t kBlock = kBlockBytes + kSampleBytes * std::size(kChannels);
  std::string bytes;
  appendNumber(kWord + kBlock, kWord, &bytes);
  appendNumber(0, kWord, &bytes);  // vendor and type: Khronos, basic
  appendNumber(kVersion, 2, &bytes);
  appendNumber(kBlock, 2, &bytes);
  for (const uint32_t byte : {kColorModelRgb, kPrimariesBt709, kTransferLinear, 0u}) appendNumber(byte, 1, &bytes);
  appendNumber(0, kWord, &bytes);  // a block is one texel
  appendNumber(kTexelBytes, 8, &bytes);
  for (size_t i = 0; i < std::size(kChannels); ++i) {
    appendNumber(16 * i, 2, &bytes);
    appendNumber(16 - 1, 1, &bytes);
    appendNumber(kChannels[i] | kSigned | kFloat, 1, &bytes);
    appendNumber(0, kWord, &bytes);  // position
    appendNumber(std::bit_cast<uint32_t>(-1.0f), kWord, &bytes);
    appendNumber(std::bit_cast<uint32_t>(1.0f), kWord, &bytes);
  }
  return bytes;
}

void pad(size_t alignment, std::string* bytes) { bytes->resize((bytes->size() + alignment - 1) / alignment * alignment, '\0'); }

// Sorted by key, as the map is; values end with a zero byte, as texts must.
std::string keyValueData(const std::map<std::string, std::string>& texts) {
  std::string bytes;
  for (const auto& [key, value] : texts) {
    appendNumber(key.size() + value.size() + 2, kWord, &bytes);
    bytes.append(key).push_back('\0');
    bytes.append(value).push_back('\0');
    pad(kWord, &bytes);
  }
  return bytes;
}

// size     of one texel or more
// texels   8 bytes each; x is the fastest index, z the slowest
// texts    by key; those that begin with KTX are the format's own
std::string ktx2Bytes(const TextureSize& size, std::string_view texels, const std::map<std::string, std::string>& texts) {
  NLG_CHECK(texels.size(), ==, kTexelBytes * texelsOf(size));
  constexpr uint32_t kRgba16f = 97, kTypeSize = 2;  // VK_FORMAT_R16G16B16A16_SFLOAT
  const std::string descriptor = dataFormatDescriptor(), key_values = keyValueData(texts);
  const size_t descriptor_place = kHeaderBytes + kLevelBytes, texts_place = descriptor_place + descriptor.size();
  const size_t texels_place = (texts_place + key_values.size() + kTexelBytes - 1) / kTexelBytes * kTexelBytes;
  std::string bytes(kIdentifier);
  for (const uint32_t number : {kRgba16f, kTypeSize, size[0], size[1], size[2], 0u /* layers: no array */, 1u /* faces */,
                                1u /* levels */, 0u /* supercompression */})
    appendNumber(number, kWord, &bytes);
  for (const size_t number : {descriptor_place, descriptor.size(), key_values.empty() ? 0 : texts_place, key_values.size()})
    appendNumber(number, kWord, &bytes);
  for (int i = 0; i < 2; ++i) appendNumber(0, 8, &bytes);  // supercompression's data
  for (const size_t number : {texels_place, texels.size(), texels.size()}) appendNumber(number, 8, &bytes);
  bytes += descriptor + key_values;
  pad(kTexelBytes, &bytes);
  return bytes.append(texels);
}

EngineFile threeFile(const LightBox& /*box*/, const std::string& texels) { return {"light.bin", texels}; }

EngineIrradiance threeIrradiance(Texture3d texture, const LightBox& box) {
  return [texture = std::move(texture), box](const PositionM& position_m, const float* normal_3) {
    PositionM moved_m;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double texel_m = (box.high_m[axis] - box.low_m[axis]) / box.texel_count[axis], margin_m = 0.01 * texel_m;
      moved_m[axis] = position_m[axis] + 0.5 * texel_m * normal_3[axis];
      if (!(moved_m[axis] >= box.low_m[axis] - margin_m && moved_m[axis] <= box.high_m[axis] + margin_m))
        return std::array<float, kShChannels>{};
    }
    return shTextureIrradiance(texture, box, moved_m, normal_3);
  };
}

template <class Three>
std::string spaced(const Three& three) {
  std::string text;
  for (const auto& number : three) text += (text.empty() ? "" : " ") + nlohmann::json(number).dump();
  return text;
}

EngineFile ktx2File(const LightBox& box, const std::string& texels) {
  return {"light.ktx2", ktx2Bytes(shTextureSize(box.texel_count), texels,
                                  {{"KTXwriter", "nlg-export engine"},
                                   {"nlg.low_m", spaced(box.low_m)},
                                   {"nlg.high_m", spaced(box.high_m)},
                                   {"nlg.resolution", spaced(box.texel_count)}})};
}

EngineIrradiance pixelIrradiance(Texture3d texture, const LightBox& box) {
  return [texture = std::move(texture), box](const PositionM& position_m, const float* normal_3) {
    return shTextureIrradiance(texture, box, position_m, normal_3);
  };
}

std::vector<EngineFile> threeModules(const ShaderGrid& grid) {
  return {{"look_up.glsl", shaderText(grid)},
          {"three_light_grid.js", std::string(kThreeLightGridText)},
          {"three_light_grid_webgpu.js", std::string(kThreeLightGridWebgpuText)}};
}

std::vector<EngineFile> cHeader(const ShaderGrid& /*grid*/) { return {{"nlg_light_grid.h", std::string(kCHeaderText)}}; }

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
  const double z = random.uniform(-1.0, 1.0), turn = 2.0 * std::numbers::pi * random.uniform(), radius = std::sqrt(1.0 - z * z);
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

const std::vector<TextureFormat>& textureFormats() {
  static const std::vector<TextureFormat> formats = {{"three", 0.5, threeFile, threeIrradiance},
                                                     {"ktx2-sh", 0.0, ktx2File, pixelIrradiance}};
  return formats;
}

const std::vector<GridFormat>& gridFormats() {
  static const std::vector<GridFormat> formats = {{"three-per-pixel", threeModules}, {"c-header", cHeader}};
  return formats;
}

std::vector<EngineFile> gridFiles(const GridFormat& format, const ShaderGrid& grid) {
  std::vector<EngineFile> files = format.look_up(grid);
  files.insert(files.begin(), {"grid.bin", shaderGridBytes(grid)});
  return files;
}

EngineIrradiance gridIrradiance(std::string bytes) {
  return [bytes = std::move(bytes)](const PositionM& position_m, const float* normal_3) {
    const NlgGrid grid = {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()};
    const float position[3] = {static_cast<float>(position_m[0]), static_cast<float>(position_m[1]),
                               static_cast<float>(position_m[2])};
    std::array<float, kShChannels> rgb;
    nlgIrradiance(&grid, position, normal_3, rgb.data());
    return rgb;
  };
}

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
    // only where light is sure: what is faint no texture need repeat
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
