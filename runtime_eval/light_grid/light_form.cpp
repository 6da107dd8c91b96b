#include "runtime_eval/light_grid/light_form.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace nlg {
namespace {

constexpr int kLinearFloats = 4 * kShChannels;             // orders 0 and 1
constexpr int kZonalHalves = kLinearFloats + kShChannels;  // zh3
constexpr int kStepCount = kShFloats - kShChannels;        // orders 1 and 2
constexpr int kStepHalves = kShChannels + 1;
constexpr float kMostSteps = 127.0f;
constexpr float kLeastOfSteps = 0x1p-16f;  // from here on a half is near enough for the largest to be 127 steps of itself
constexpr int kMeanExponent = 10;          // the largest Y00 is below 2^10
constexpr int kLeastExponent = -115, kMostExponent = 22;               // of the scale: light up to 2^30
constexpr std::array<float, 3> kLuminance{0.2126f, 0.7152f, 0.0722f};  // ITU-R BT.709
constexpr float kPerZonal = 1.58533092f;  // sqrt(4 pi / 5): Y2m of one direction, times this, have length 1

struct FormKind {
  const char* name;
  int halves, steps;  // numbers a probe
};
constexpr FormKind kForms[] = {{"none", 0, 0},
                               {"sh2_float16", kShFloats, 0},
                               {"sh2_8bit", kStepHalves, kStepCount},
                               {"zh3_float16", kZonalHalves, 0},
                               {"sh1_float16", kLinearFloats, 0}};
const FormKind& kindOf(LightForm form) { return kForms[static_cast<size_t>(form)]; }

// The basis functions of order 2 along the direction of the luminance's linear part, times kPerZonal. Along z where there is none.
std::array<float, 5> zonalBasis(const float* light_9x3) {
  float along[3];  // coefficients of y, z, x
  for (int i = 0; i < 3; ++i) {
    along[i] = 0.0f;
    for (int c = 0; c < kShChannels; ++c) along[i] += kLuminance[c] * light_9x3[(i + 1) * kShChannels + c];
  }
  const float length = std::sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
  const std::array<float, kShCount> basis =
      length > 0.0f ? shBasis(along[2] / length, along[0] / length, along[1] / length) : shBasis(0.0f, 0.0f, 1.0f);
  std::array<float, 5> zonal;
  for (int i = 0; i < 5; ++i) zonal[i] = kPerZonal * basis[4 + i];
  return zonal;
}

// Packs one probe after another. add… return false where a number is beyond float16.
class LightPacker {
 public:
  LightPacker(LightForm form, PackedLight* packed) : form_(form), packed_(*packed) {}

  // scaled_9x3   kShFloats floats over the common scale
  bool add(const float* scaled_9x3) {
    if (form_ == LightForm::sh2_8bit) return addSteps(scaled_9x3);
    if (form_ == LightForm::zh3_float16) return addZonal(scaled_9x3);
    return addHalves(scaled_9x3, kindOf(form_).halves);
  }

 private:
  bool addHalves(const float* values, int count) {
    for (int i = 0; i < count; ++i) {
      Half& half = packed_.halves.emplace_back();
      if (!halfFromFloat(values[i], &half)) return false;
      if ((half.bits & 0x7fff) == 0) half.bits = 0;  // one zero
    }
    return true;
  }

  bool addZonal(const float* scaled_9x3) {
    if (!addHalves(scaled_9x3, kLinearFloats)) return false;
    float stored[kLinearFloats];  // as the reader has it, so that both find the same direction
    std::transform(packed_.halves.end() - kLinearFloats, packed_.halves.end(), stored, floatFromHalf);
    const std::array<float, 5> zonal = zonalBasis(stored);
    float along[kShChannels] = {};
    for (int i = 0; i < 5; ++i) {
      for (int c = 0; c < kShChannels; ++c) along[c] += zonal[i] * scaled_9x3[(4 + i) * kShChannels + c];
    }
    return addHalves(along, kShChannels);
  }

  bool addSteps(const float* scaled_9x3) {
    float largest = 0.0f;
    for (int i = kShChannels; i < kShFloats; ++i) largest = std::max(largest, std::abs(scaled_9x3[i]));
    if (largest < kLeastOfSteps) largest = 0.0f;
    if (!addHalves(scaled_9x3, kShChannels) || !addHalves(&largest, 1)) return false;
    const float stored = floatFromHalf(packed_.halves.back());
    for (int i = kShChannels; i < kShFloats; ++i) {
      const float steps = stored > 0.0f ? std::nearbyint(kMostSteps * (scaled_9x3[i] / stored)) : 0.0f;
      packed_.steps.push_back(static_cast<int8_t>(std::clamp(steps, -kMostSteps, kMostSteps)));
    }
    return true;
  }

  LightForm form_;
  PackedLight& packed_;
};

// The power of two over which the largest Y00, as a half, lies in [2^9, 2^10).
float commonScale(const std::vector<float>& light) {
  float largest = 0.0f;
  for (size_t i = 0; i < light.size(); ++i) {
    if (i % kShFloats < kShChannels) largest = std::max(largest, std::abs(light[i]));
  }
  if (largest == 0.0f) return 1.0f;
  int exponent = 0;
  std::frexp(largest, &exponent);
  const float scale = std::ldexp(1.0f, std::clamp(exponent - kMeanExponent, kLeastExponent, kMostExponent));
  Half rounded;
  halfFromFloat(largest / scale, &rounded);
  return floatFromHalf(rounded) < std::ldexp(1.0f, kMeanExponent) ? scale : 2.0f * scale;
}

FileResult checkPacked(LightForm form, const PackedLight& packed, size_t probe_count) {
  const FormKind& kind = kindOf(form);
  const auto sized = [&](const char* what, size_t size, int per_probe) {
    const size_t expected = probe_count * static_cast<size_t>(per_probe);
    if (size == expected) return FileResult{};
    return FileResult{FileStatus::tensor_unexpected,
                      std::string(what) + ": " + std::to_string(size) + " values; expected " + std::to_string(expected)};
  };
  for (const FileResult& result :
       {sized("light.halves", packed.halves.size(), kind.halves), sized("light.steps", packed.steps.size(), kind.steps)}) {
    if (!result.ok()) return result;
  }
  int exponent = 0;
  const bool is_scale = std::isfinite(packed.scale) && std::frexp(packed.scale, &exponent) == 0.5f &&
                        exponent - 1 >= kLeastExponent && exponent - 1 <= kMostExponent;
  if (!is_scale) return {FileStatus::value_out_of_range, "light.scale: expected a power of two, 2^-115 to 2^22"};
  for (size_t i = 0; i < packed.halves.size(); ++i) {
    const float value = floatFromHalf(packed.halves[i]);
    if (!std::isfinite(value)) return {FileStatus::value_not_finite, "light.halves: value " + std::to_string(i)};
  }
  const auto step = std::find(packed.steps.begin(), packed.steps.end(), int8_t{-128});
  if (step != packed.steps.end())
    return {FileStatus::value_out_of_range, "light.steps: value " + std::to_string(step - packed.steps.begin())};
  return {};
}

void unpackProbe(LightForm form, const PackedLight& packed, size_t probe, float* light_9x3) {
  const FormKind& kind = kindOf(form);
  const Half* halves = &packed.halves[probe * static_cast<size_t>(kind.halves)];
  std::fill_n(light_9x3, kShFloats, 0.0f);
  const int plain = form == LightForm::zh3_float16 ? kLinearFloats : form == LightForm::sh2_8bit ? kShChannels : kind.halves;
  for (int i = 0; i < plain; ++i) light_9x3[i] = floatFromHalf(halves[i]);
  if (form == LightForm::zh3_float16) {
    const std::array<float, 5> zonal = zonalBasis(light_9x3);
    for (int i = 0; i < 5; ++i) {
      for (int c = 0; c < kShChannels; ++c)
        light_9x3[(4 + i) * kShChannels + c] = zonal[i] * floatFromHalf(halves[kLinearFloats + c]);
    }
  }
  if (form == LightForm::sh2_8bit) {
    const float largest = floatFromHalf(halves[kShChannels]);
    const int8_t* steps = &packed.steps[probe * kStepCount];
    // the largest itself comes back as the same number
    for (int i = 0; i < kStepCount; ++i) light_9x3[kShChannels + i] = largest * (static_cast<float>(steps[i]) / kMostSteps);
  }
  for (int i = 0; i < kShFloats; ++i) light_9x3[i] *= packed.scale;
}

}  // namespace

const char* lightFormName(LightForm form) { return kindOf(form).name; }

bool findLightForm(std::string_view name, LightForm* form) {
  for (const LightForm known : kLightForms) {
    if (name != lightFormName(known)) continue;
    *form = known;
    return true;
  }
  return false;
}

size_t lightFormBytes(LightForm form) {
  const FormKind& kind = kindOf(form);
  return static_cast<size_t>(kind.halves) * sizeof(Half) + static_cast<size_t>(kind.steps);
}

FileResult packLight(LightForm form, const std::vector<float>& light, PackedLight* packed) {
  *packed = {};
  if (form == LightForm::none) return {};
  packed->scale = commonScale(light);
  LightPacker packer(form, packed);
  for (size_t probe = 0; probe < light.size() / kShFloats; ++probe) {
    float scaled[kShFloats];
    for (size_t i = 0; i < kShFloats; ++i) scaled[i] = light[probe * kShFloats + i] / packed->scale;
    if (packer.add(scaled)) continue;
    *packed = {};
    return {FileStatus::value_out_of_range,
            "light of probe " + std::to_string(probe) + ": a coefficient beyond float16, and 32 times the largest Y00"};
  }
  return {};
}

FileResult unpackLight(LightForm form, const PackedLight& packed, size_t probe_count, std::vector<float>* light) {
  light->clear();
  FileResult result = checkPacked(form, packed, probe_count);
  if (!result.ok() || form == LightForm::none) return result;
  light->resize(probe_count * kShFloats);
  for (size_t probe = 0; probe < probe_count; ++probe) unpackProbe(form, packed, probe, &(*light)[probe * kShFloats]);
  return {};
}

FileResult roundLight(LightForm form, std::vector<float>* light) {
  PackedLight packed;
  const size_t probe_count = light->size() / kShFloats;
  const FileResult result = packLight(form, *light, &packed);
  return result.ok() ? unpackLight(form, packed, probe_count, light) : result;
}

}  // namespace nlg
