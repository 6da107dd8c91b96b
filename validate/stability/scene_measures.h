// What the cases of scenes have in common: which probes they take, what must hold of any scene, and their words and figures.
#pragma once

#include <string>

#include "validate/stability/face_scene.h"
#include "validate/stability/stability_case.h"

namespace nlg {

// Placement whose finest spacing is this one, not drawn.
ProbePlacementOptions exactSpacing(double spacing_m);

constexpr double kRoomSpacing_m = 0.7;  // of a furnished room

// As many probes of a scene as the suite's depth allows.
ProbeFunctions probeFunctions(const StabilityInputs& inputs, const Scene& scene, double spacing_m = kRoomSpacing_m);

std::string describe(const ProbeFunctions& probes);
std::string describe(const FunctionDifference& apart);
void addFigures(const ProbeFunctions& probes, StabilityResult* result);
void addFigures(const FunctionDifference& apart, StabilityResult* result);

// Soundness alone: whatever the triangles are, every probe has an outcome and every function keeps its promises, twice alike.
constexpr const char* kSoundMustHold =
    "every probe has an outcome, every phi is in [0, 1] and 0 in solid, and a second run gives the same bits";
StabilityResult measureSound(const StabilityInputs& inputs, const FaceScene& faces);

}  // namespace nlg
