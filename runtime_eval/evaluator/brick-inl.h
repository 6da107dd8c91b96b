// Evaluates bricks of logits at vectors of points of one cell, for any Highway target. Included once per target; see Highway's
// quick reference on "-inl.h".
#if defined(NLG_BRICK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NLG_BRICK_INL_H_
#undef NLG_BRICK_INL_H_
#else
#define NLG_BRICK_INL_H_
#endif

#include <hwy/highway.h>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/product_field-inl.h"

HWY_BEFORE_NAMESPACE();
namespace nlg {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kMaxBrickCells = (kMaxBrickResolution - 1) * (kMaxBrickResolution - 1) * (kMaxBrickResolution - 1);

// The logits of every cell as a polynomial of the centred coordinates: coefficient of 1, x, y, xy, z, xz, yz, xyz, by cell.
struct BrickPolynomials {
  alignas(64) float coefficient[8][kMaxBrickCells + 16];
};

// logits   r³ floats and as many behind them as a vector has
HWY_INLINE void brickPolynomials(int resolution, const float* HWY_RESTRICT logits, BrickPolynomials& polynomials) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d)), cells = resolution - 1;
  const Floats eighth = hn::Set(d, 0.125f);
  // rows of cells in their order: what a vector writes behind its row, the next row overwrites
  for (int row = 0; row < cells * cells; ++row) {
    const int y = row % cells, z = row / cells;
    const float* node = logits + resolution * (y + resolution * z);
    for (int x = 0; x < cells; x += lanes) {
      Floats corner[8];
#pragma GCC unroll 8
      for (int c = 0; c < 8; ++c)
        corner[c] = hn::Mul(eighth, hn::LoadU(d, node + x + (c & 1) + resolution * ((c >> 1 & 1) + resolution * (c >> 2))));
#pragma GCC unroll 3
      for (int axis = 1; axis < 8; axis *= 2) {
#pragma GCC unroll 8
        for (int c = 0; c < 8; ++c) {
          if (c & axis) continue;
          const Floats low = corner[c], high = corner[c | axis];
          corner[c] = hn::Add(low, high);
          corner[c | axis] = hn::Sub(high, low);
        }
      }
#pragma GCC unroll 8
      for (int c = 0; c < 8; ++c) hn::StoreU(corner[c], d, &polynomials.coefficient[c][row * cells + x]);
    }
  }
}

// The logit at one vector of points of cell c.
HWY_INLINE Floats cellLogit(FloatTag d, const BrickPolynomials& polynomials, int c, const CellPosition& at) {
  const auto alongX = [&](int i) {
    return hn::MulAdd(hn::Set(d, polynomials.coefficient[i + 1][c]), at.x, hn::Set(d, polynomials.coefficient[i][c]));
  };
  return hn::MulAdd(hn::MulAdd(alongX(6), at.y, alongX(4)), at.z, hn::MulAdd(alongX(2), at.y, alongX(0)));
}

}  // namespace HWY_NAMESPACE
}  // namespace nlg
HWY_AFTER_NAMESPACE();
#endif
