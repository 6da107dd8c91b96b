// The forms in which a file holds the light of probes, and what they cost of it.
//
//     sh2_float16   all 27 coefficients of order 2 as float16                                                     54 bytes a probe
//     sh2_8bit      Y00 of each channel as float16; the other 24 as signed bytes over their largest, a float16    32
//     zh3_float16   order 1 and, a channel, one coefficient of order 2 along the probe's main direction           30
//     sh1_float16   the 12 coefficients of order 1                                                                24
//
// All numbers are stored over one power of two for the whole grid that brings the largest Y00 into [2^9, 2^10), so that bright and
// dim light fit float16 alike. zh3 is that of Roughton, Sloan, Silvennoinen, Iwanicki and Shirley, "ZH3: Quadratic Zonal
// Harmonics" (I3D 2024): the main direction is that of the luminance's linear part, and follows from the order 1 that is stored.
// In memory light always has 27 floats a probe; what a form leaves out is 0 there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "runtime_eval/light_grid/spherical_harmonics.h"
#include "runtime_eval/numbers/half.h"
#include "runtime_eval/weights_file/file_result.h"

namespace nlg {

enum class LightForm : uint8_t { none, sh2_float16, sh2_8bit, zh3_float16, sh1_float16 };
inline constexpr LightForm kLightForms[] = {LightForm::none, LightForm::sh2_float16, LightForm::sh2_8bit, LightForm::zh3_float16,
                                            LightForm::sh1_float16};

// "none", "sh2_float16", …
const char* lightFormName(LightForm form);
// false when there is none of that name
bool findLightForm(std::string_view name, LightForm* form);

// Bytes of a probe's light in a file.
size_t lightFormBytes(LightForm form);

// The light of Q probes in a form.
struct PackedLight {
  float scale = 1.0f;  // a power of two, 2^-115 to 2^22: what every number is multiplied by
  std::vector<Half>
      halves;  // a probe, in the order of memory: sh2 27; zh3 12, then 3 of order 2; sh1 12; 8 bits: 3 of Y00, then the
               // largest |coefficient| of the others
  std::vector<int8_t> steps;  // 8 bits: 24 a probe, -127 … 127: 127ths of the largest
};

// Rounds to nearest. With S the largest |coefficient| of orders 1 and 2 of a probe and M the grid's largest Y00: bytes are off by
// at most S / 254, or by 2^-25 M where that is more; halves by 2^-11 of themselves, or 2^-34 M. What was unpacked packs to the same numbers.
//
// light    kShFloats floats a probe, |light| <= kMaxGridLight (light_grid.h)
// returns  ok; or value_out_of_range and which probe: a coefficient is more than 32 times the grid's largest Y00 and beyond
//          float16, which no light is
FileResult packLight(LightForm form, const std::vector<float>& light, PackedLight* packed);

// What a file held, checked: sizes against probe_count, numbers finite and in range.
// returns   ok; tensor_unexpected (a size), value_not_finite or value_out_of_range, with one line that says where; *light is
//           empty then
FileResult unpackLight(LightForm form, const PackedLight& packed, size_t probe_count, std::vector<float>* light);

// What a form makes of light: packed, then unpacked. With none, nothing is left.
FileResult roundLight(LightForm form, std::vector<float>* light);

}  // namespace nlg
