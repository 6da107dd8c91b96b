// Errors of a method's picture of a view against truth, at its receivers.
//
// The eye adapts: a view is exposed by its own truth, so that a dark room counts as much as a terrace. The exposure is
// render/tone.h's: the median luminance is shown as middle grey, .18; but no eye adapts to less than kLeastLight. Colours are
// compared as a display shows them, cut off at 1 and not by the pictures' tone curve, so that figures stay comparable, by HyAB in CIE
// L*a*b* (D65). That is not FLIP, of which HyAB is the colour part alone: FLIP's filters say what is seen from afar in a picture of a
// known size, and a player's is none. Andersson and others, "FLIP: a difference evaluator for alternating images" (HPG 2020); Abasi
// and others, "Distance metrics for very large color differences" (2020).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/lit_picture.h"
#include "validate/views/view_truth.h"

namespace nlg {

inline constexpr double kOffFactor = 2.0;       // of light that is off
inline constexpr double kEighth = 1.0 / 8.0;    // of truth's light: what has less is a black spot
inline constexpr double kSureDeviations = 1.0;  // of truth's noise: what differs by less is not off
// Of the irradiance that the eye has adapted to: where neither truth nor answer has more, all is black to it. A surface of the view's
// median colour is shown as .0018 there, L* 1.6, and less than 2.3 is not seen.
inline constexpr double kBlackOfMedian = 0.01;
// Of the median irradiance of the scene's brightest view, or of a tenth of its brightest source where that is more (render/tone.h): a
// view that has less is shown darker than middle grey, and one without any light stays black.
inline constexpr double kLeastLight = 1e-3;
// Of medianNoise: with more, three standard deviations are as much as light off by kOffFactor, at half of the receivers.
inline constexpr double kMostNoise = (kOffFactor - 1.0) / 3.0;
inline constexpr double kRingM = 0.2;             // around a receiver
inline constexpr double kRingDarker = 2.0 / 3.0;  // of the least truth there: a ring is darker
inline constexpr float kRingNormal = 0.9f;        // cosine between normals of surfaces that are held against each other

// linear_rgb   sRGB's primaries, shown as a display does: clamped to [0, 1]
glm::vec3 labOf(const glm::vec3& linear_rgb);

// |difference of L*| + distance in a*, b*. Black and white are 100 apart; 2.3 is about what is just seen.
float hyAb(const glm::vec3& lab_a, const glm::vec3& lab_b);

struct ViewTruth {
  std::vector<LightAnswer> at;      // by sample
  std::vector<float> least_nearby;  // luminance: the least truth within kRingM, of like normals; by sample
  double exposure = 1.0;
  double median = 0.0;        // medianLight
  double least = 0.0;         // that an eye adapts to
  double adapted = 0.0;       // the median, or that
  double noise = 0.0;         // root mean square of its standard deviation, over that of truth
  double median_noise = 0.0;  // medianNoise, which --truth-noise bounds
  double colour_noise = 0.0;  // HyAB between truth and truth plus one standard deviation, the mean

  bool isKnown() const { return median_noise <= kMostNoise; }  // well enough to hold answers against
  // a hollow where truth is black everywhere is no picture that a player sees: whatever leaks into it would outweigh the lit views
  bool isLit() const { return median > 0.0; }
  bool isCounted() const { return isKnown() && isLit(); }
};

// Median luminance of the irradiance of receivers that are not black; 0 where all are.
double medianLight(const Sights& sights, const std::vector<LightAnswer>& truth);

// brightest   medianLight of the scene's brightest view
ViewTruth truthOf(const ViewSurfaces& surfaces, std::vector<LightAnswer> truth, double brightest, int thread_count);

struct OffShares {
  double brighter = 0.0, darker = 0.0;
};

// Of the receivers of one class. Light is the luminance of irradiance.
struct ViewFigures {
  uint64_t receivers = 0;
  double colour = 0.0;        // mean HyAB
  double energy = 1.0;        // the answers' mean over truth's; 1 where truth is black
  OffShares off;              // shares off by more than kOffFactor, truth's noise allowed for
  double below_eighth = 0.0;  // share with less than kEighth of truth's light, likewise
  double ringing = 0.0;       // share that is darker than a ring may be
};
using ViewFiguresByClass = std::array<ViewFigures, kViewClassCount>;

// answers   by sample
ViewFiguresByClass viewFigures(const ViewSurfaces& surfaces, const ViewTruth& truth, const std::vector<LightAnswer>& answers);

// Of several views: means that count every view alike; of classes, by the class's receivers.
ViewFiguresByClass meanFigures(const std::vector<ViewFiguresByClass>& views);

}  // namespace nlg
