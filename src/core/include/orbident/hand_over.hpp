// The hand-over of the information filter from the linear parameters y to the base parameters beta.
//
// Samples are linear in y and y(beta) is not; a factor over y forgets nothing, but for two arms of
// seven joints it has 527 columns and beta 108. Once the estimate is so good that y(beta) is linear
// as far as it is uncertain, the factor over beta, of the last Gauss-Newton step, says all that the
// samples said. From then on each sample's rows are linearised about the estimate before it:
//
//   X (y(beta_0) + J (beta - beta_0)) = z
//
// What this does to the estimate is, over its deviations, at most the length of
// R (y(beta) - y(beta_0) - J (beta - beta_0)), with d = beta - beta_0, phi' = phi(beta), M' = M +
// dM and C as in y(beta)
//
//   R [C M' (phi'_a - phi_a) (phi'_b - phi_b) | -(phi' - phi) dM / M]
//
// and later samples, about better estimates, add less than that. The same terms bound what rows of
// different beta_0 say of directions that no row of one beta_0 says anything of.
#pragma once

#include "orbident/triangles.hpp"

namespace orbident {

// Of the linearisation's error, squared, over the deviations: 1/20 of one in the worst direction.
constexpr Real LINEAR = Real(0.0025);
// Points in a row that must be linear, one a sample: so many of Walsh's functions are orthogonal.
constexpr int LINEAR_POINTS = 32;
// What the known term of the momentum equation is at least, squared, over its noise, a row of pi.
constexpr Real KNOWN = 100.0;

// Whether the filter has handed over: `root` goes on, `top` is [N | B | z] over [iota, M, sigma]
// with N x + B beta = z, and `R` stays what it was.
inline bool held_in_beta(const FilterState& state) { return *state.linear == LINEAR_POINTS; }

// Rows [y | z] become rows [iota, M, sigma | z] in place, linearised about the estimate.
inline void rows_of_beta(const FilterModel& model, const FilterState& state, Real* y_z, int stride,
                         int count, int width, FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const int iotas = size.iotas, shown = size.shown;
  for (int i = 0; i < model.sets.sigmas; ++i) room.phi[i] = state.beta[1 + i] / state.beta[0];
  for (int first = 0; first < count; first += TILE) {
    const int rows = count - first < TILE ? count - first : TILE;
    shown_columns(model.sets, y_z + first * stride, stride, rows, 0, room.phi, state.beta[0],
                  room.transposed, room.shown);
    for (int r = 0; r < rows; ++r) {
      Real* const row = y_z + (first + r) * stride + iotas;
      for (int c = 0; c <= shown; ++c) row[c] = room.shown[c * TILE + r];
      for (int c = shown + 1; c < width - iotas; ++c) row[c] = 0.0;
    }
  }
}

// Whether y(beta) is linear up to beta + d, with d one deviation in every direction; Walsh's
// function number `point` has the signs of the directions.
ORBIDENT_WIDEST inline bool linear(const FilterModel& model, const FilterState& state, int point,
                                   FilterRoom& room) {
  const ParametersOfBeta& sets = model.sets;
  const FilterSizes size = model.sizes();
  const int shown = size.shown, stride = size.beta_stride(), y = size.parameters;
  Real* const d = room.beta;
  for (int i = shown - 1; i >= 0; --i) {
    const Real* const row = state.root + (size.iotas + i) * stride + size.iotas;
    int odd = 0;
    for (int bits = i & point; bits; bits &= bits - 1) odd ^= 1;
    d[i] = (Real(odd ? -1 : 1) - dot(row + i + 1, d + i + 1, shown - i - 1)) / row[i];
  }
  const Real M = state.beta[0], far = M + d[0];
  Real* const turned = room.phi;
  for (int i = 0; i < sets.sigmas; ++i)
    turned[i] = (state.beta[1 + i] + d[1 + i]) / far - state.beta[1 + i] / M;
  Real* const bent = room.y;
  for (int k = 0; k < sets.pis; ++k) bent[k] = 0.0;
  for (int p = 0; p < sets.pi_of_products.columns; ++p) {
    const Real product = far * turned[sets.pair[2 * p]] * turned[sets.pair[2 * p + 1]];
    for (int k = sets.pi_of_products.first[p]; k < sets.pi_of_products.first[p + 1]; ++k)
      bent[sets.pi_of_products.row[k]] += sets.pi_of_products.value[k] * product;
  }
  for (int i = 0; i < sets.sigmas; ++i) bent[sets.pis + i] = -turned[i] * d[0] / M;
  Real square = 0.0;
  for (int i = 0; i < y; ++i) {
    const Real part = dot(state.R + static_cast<long>(i) * size.R_stride() + i, bent + i, y - i);
    square += part * part;
  }
  return square < LINEAR;
}

// Whether the momentum equation has a known term that is more than noise: else the samples tell no
// scale. Noise counts as that of a robot of the mass M_0: without a scale the estimate shrinks to
// nothing, and beside so small a robot's noise anything would be known.
inline bool scaled(const FilterModel& model, const FilterState& state, Real M_0) {
  const FilterSizes size = model.sizes();
  if (held_in_beta(state)) return true;
  Real known = 0.0;
  for (int i = 0; i < model.sets.pis; ++i) {
    const Real z = state.R[static_cast<long>(i) * size.R_stride() + size.parameters];
    known += z * z;
  }
  const Real part = state.beta[0] / M_0;
  return model.laws.robot.wheels > 0 &&
         known * part * part > KNOWN * static_cast<Real>(model.sets.pis);
}

// Tests one more point, and hands over after enough of them.
inline void hand_over_if_linear(const FilterModel& model, FilterState& state, FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const int point = static_cast<int>(*state.linear), n = size.nuisances, k = size.betas();
  // A body without joints: nothing shows its mass, and beta is no shorter than y.
  if (k > size.parameters) return;
  const bool more = linear(model, state, point, room);
  if (more && point + 1 == LINEAR_POINTS) {
    solve_triangle(state.prior, size.beta_stride(), k, room.beta);
    if (!scaled(model, state, room.beta[size.iotas])) return;
    const auto reduce = [&](Real* rows, int count) {
      rows_of_beta(model, state, rows + n, size.top_stride(), count, padded(n + k + 1) - n, room);
    };
    reduce(state.top, n);
    reduce(state.slope, size.driven);
  }
  *state.linear = more ? Real(point + 1) : Real(0);
}

}  // namespace orbident
