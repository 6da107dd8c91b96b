// The difference of two colours: HyAB in CIE L*a*b* (D65), on which FLIP builds its colour part. Andersson and others, "FLIP:
// a difference evaluator for alternating images" (HPG 2020); Abasi and others, "Distance metrics for very large color
// differences" (2020).
#pragma once

#include <glm/glm.hpp>

namespace nlg {

// linear_rgb   sRGB's primaries, shown as a display does: clamped to [0, 1]
glm::vec3 labOf(const glm::vec3& linear_rgb);

// |difference of L*| + distance in a*, b*. Black and white are 100 apart; 2.3 is about what is just seen.
float hyAb(const glm::vec3& lab_a, const glm::vec3& lab_b);

}  // namespace nlg
