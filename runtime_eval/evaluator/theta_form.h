// Number formats of theta in the file of a light grid, and the rounding to them.
//
// int8 keeps the hidden layers of a network in a byte a number, and its last layer in float16: 122 bytes for `mlp` and
// `tent_mlp`, 26 for `tent_mlp4`. Of the last layer of `tent_mlp4` and `tent_mlp44` it keeps four bits behind the highest, and the file's
// code takes the others away. No scale is stored. LeakyReLU is homogeneous: a hidden unit whose weights and bias are
// multiplied by a > 0, while all that read it divide by a, leaves the network what it is. So every unit is scaled until the
// largest of its numbers is 127 steps or a few less, and a step is one number for all (stepOf). What rounding does to the hidden layers, an
// exact last layer makes up for (fit/last_layer.h); figures: docs/lab/training.md. Product fields stay in float16. A code keeps a
// byte a number, of as many groups of 8 as it needs: what lies behind is 0. Its bytes are steps of 2^e, the least for which its largest number
// fits; groups and e are one more byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/numbers/half.h"

namespace nlg {

// How many numbers of one theta a precision holds in which form; together they are D.
struct ThetaForm {
  int floats = 0, halves = 0, steps = 0;
  size_t bytes() const { return floats * sizeof(float) + halves * sizeof(Half) + steps * sizeof(int8_t); }
};
ThetaForm thetaForm(const Representation& representation, ThetaPrecision precision);

// "float32", "float16", "int8".
const char* thetaPrecisionName(ThetaPrecision precision);

// A step of a hidden layer's numbers in int8: 4 for networks of one hidden layer, 1/32 for those of two. The last layer of ordinary
// fits then comes to lie where float16 is fine: with 1/2 it often falls below 2^-14, and its rounding is seen.
float stepOf(const NetworkShape& shape);

// Steps of the largest number of a unit of each hidden layer, 1 … kMostThetaSteps. Which it is, is free: other sizes round otherwise.
inline constexpr int kMostThetaSteps = 127;
// So many are enough: with more no function errs less, and a file is larger (docs/lab/training.md).
int enoughThetaSteps(const NetworkShape& shape);
struct UnitSteps {
  int first = kMostThetaSteps, second = kMostThetaSteps;
};

// Scales every hidden unit of a network; what reads a unit takes its scale. Units whose numbers are whole steps already stay, bit for
// bit. theta: D finite floats
void scaleHiddenLayers(const Representation& network, float* theta, UnitSteps most = {});

// The same, and rounds the numbers of the hidden layers to steps: a theta that was rounded before stays, bit for bit.
void roundHiddenLayers(const Representation& network, float* theta, UnitSteps most = {});

// The numbers that a file in this precision gives back, in place: nearest, ties to even.
// theta     D finite floats
// returns   false, theta unchanged, when a number is beyond float16, or of a code not finite
bool roundTheta(const Representation& representation, ThetaPrecision precision, float* theta);

// Numbers of a code that are stored: whole groups of kCodeGroup, up to the last that is not 0.
inline constexpr int kCodeGroup = 8;
int codeLength(int count, const float* z);

// e, from 0 to kMostCodeExponent; beyond, numbers do not fit.
inline constexpr int kMostCodeExponent = 7;
int codeExponent(int count, const float* z);

// Bytes of one theta in a file: of a code in int8 its length, and the byte that says its groups and e.
size_t storedThetaBytes(const Representation& representation, ThetaPrecision precision, const float* theta);

// Many theta in int8, one behind another: the steps and the halves of each, and of codes groups + 32 e.
struct PackedTheta {
  std::vector<int8_t> steps;
  std::vector<Half> halves;
  std::vector<uint8_t> groups;
};
inline constexpr int kCodeExponentUnit = 32;

// Adds one. theta   rounded to int8 by roundTheta
void packTheta(const Representation& representation, const float* theta, PackedTheta* packed);
// The inverse, exactly: D floats from the steps and halves of one that is no code.
void unpackTheta(const Representation& representation, const int8_t* steps, const Half* halves, float* theta);
// Of a code: K floats.
// returns   false where packTheta would have given other groups or another e
bool unpackCode(int count, uint8_t groups, const int8_t* steps, float* theta);

}  // namespace nlg
