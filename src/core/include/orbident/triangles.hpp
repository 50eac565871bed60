// Triangular systems of the information filter.
#pragma once

#include "orbident/filter_state.hpp"

namespace orbident {

// x . y in four sums of every fourth entry: a fixed order that vectors of any width keep.
ORBIDENT_INLINE Real dot(const Real* x, const Real* y, int n) {
  Real sums[4] = {0.0, 0.0, 0.0, 0.0};
  int k = 0;
  for (; k + 4 <= n; k += 4)
    for (int l = 0; l < 4; ++l) sums[l] += x[k + l] * y[k + l];
  for (; k < n; ++k) sums[0] += x[k] * y[k];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

// x of R x = z, from n rows [R | z] at a stride.
ORBIDENT_WIDEST inline void solve_triangle(const Real* R_z, int stride, int n, Real* x) {
  for (int i = n - 1; i >= 0; --i) {
    const Real* const row = R_z + static_cast<long>(i) * stride;
    x[i] = (row[n] - dot(row + i + 1, x + i + 1, n - i - 1)) / row[i];
  }
}

// Standard deviations of beta, from the rows of root^-1, TILE at a time: w root = e_i from the
// left.
ORBIDENT_WIDEST inline void deviations(const FilterModel& model, const FilterState& state,
                                       FilterRoom& room, Real* std) {
  const FilterSizes size = model.sizes();
  const int k = size.betas(), stride = size.beta_stride();
  for (int first = 0; first < k; first += TILE) {
    Real squares[TILE] = {};
    for (int j = first; j < k; ++j)
      for (int l = 0; l < TILE; ++l) room.transposed[j * TILE + l] = j == first + l ? 1.0 : 0.0;
    for (int j = first; j < k; ++j) {
      const Real* const row = state.root + j * stride;
      Real* __restrict const w = room.transposed + j * TILE;
      const Real inverse = 1 / row[j];
      for (int l = 0; l < TILE; ++l) {
        w[l] *= inverse;
        squares[l] += w[l] * w[l];
      }
      for (int c = j + 1; c < k; ++c) add(-row[c], w, room.transposed + c * TILE);
    }
    for (int i = first; i < k && i < first + TILE; ++i)
      std[i < size.iotas ? size.shown + i : i - size.iotas] = std::sqrt(squares[i - first]);
  }
}

}  // namespace orbident
