// The linear parameters y = [pi, phi] of the base parameters beta = [M, sigma, iota]; R dy/dbeta.
//
//   pi = [iota, 0] + G [M, sigma] + C (sigma_a sigma_b / M),   phi = sigma / M
//
// with G and C sparse. pi is homogeneous of degree one in beta and phi of degree zero, so that with
// J = dy/dbeta
//
//   J beta = y - [0, phi]
//   d(sigma_a sigma_b / M) = phi_b dsigma_a + phi_a dsigma_b - phi_a phi_b dM
//
// J is the identity over iota and the first rows, and zero below: in the order [iota, M, sigma] the
// product of a triangular R with J begins with R's own triangle.
#pragma once

#include "orbident/householder.hpp"
#include "orbident/regressors.hpp"

namespace orbident {

// Views of constant tables.
struct ParametersOfBeta {
  Sparse pi_of_shown;     // G: pi x [M, sigma]
  Sparse pi_of_products;  // C: pi x pairs, in the order of their last rows
  const int* pair;        // pairs x 2: which of sigma are multiplied
  int pis, sigmas, iotas;
  constexpr int shown() const { return 1 + sigmas; }
  constexpr int betas() const { return 1 + sigmas + iotas; }
  constexpr int size() const { return pis + sigmas; }
};

// y near beta_0: y(beta_0) + J (beta - beta_0), with J at beta_0; in place of y.
inline void linearised(const ParametersOfBeta& sets, const Real* beta_0, const Real* beta,
                       Real* y) {
  const Real M_0 = beta_0[0], M = beta[0];
  const Real *sigma_0 = beta_0 + 1, *sigma = beta + 1, *iota = beta + sets.shown();
  for (int k = 0; k < sets.pis; ++k) y[k] = k < sets.iotas ? iota[k] : Real(0);
  for (int c = 0; c < sets.shown(); ++c)
    for (int k = sets.pi_of_shown.first[c]; k < sets.pi_of_shown.first[c + 1]; ++k)
      y[sets.pi_of_shown.row[k]] += sets.pi_of_shown.value[k] * beta[c];
  for (int p = 0; p < sets.pi_of_products.columns; ++p) {
    const int a = sets.pair[2 * p], b = sets.pair[2 * p + 1];
    const Real phi_a = sigma_0[a] / M_0, phi_b = sigma_0[b] / M_0;
    const Real product = phi_b * sigma[a] + phi_a * sigma[b] - phi_a * phi_b * M;
    for (int k = sets.pi_of_products.first[p]; k < sets.pi_of_products.first[p + 1]; ++k)
      y[sets.pi_of_products.row[k]] += sets.pi_of_products.value[k] * product;
  }
  for (int k = 0; k < sets.sigmas; ++k) {
    const Real phi = sigma_0[k] / M_0;
    y[sets.pis + k] = phi + (sigma[k] - phi * M) / M_0;
  }
}

// So many rows of R go with one pass over the tables.
constexpr int TILE = 16;

// y + a x of one column. Not unrolled, the loop becomes vectors; unrolled, GCC 12 makes single
// numbers of it.
ORBIDENT_INLINE void add(Real a, const Real* __restrict x, Real* __restrict y) {
#pragma GCC unroll 1
  for (int r = 0; r < TILE; ++r) y[r] += a * x[r];
}

// X J over [M, sigma] and z + X (J beta - y) of some rows [X | z] of X y = z, which is what
// X (y(beta_0) + J (beta - beta_0)) = z says of beta.
//
//   X, z       `stride` entries from row to row; zero before column `first`
//   count      at most TILE
//   phi        at beta_0, with M_0
//   transposed room for TILE x size entries
//   out        (1 + shown) x TILE: the result column by column, the last is the right side
ORBIDENT_WIDEST inline void shown_columns(const ParametersOfBeta& sets, const Real* X, int stride,
                                          int count, int first, const Real* phi, Real M_0,
                                          Real* transposed, Real* out) {
  const int size = sets.size();
  // Rows behind the last one repeat it, and are not used.
  const Real* row_of[TILE];
  for (int r = 0; r < TILE; ++r) row_of[r] = X + (r < count ? r : count - 1) * stride;
  for (int k = first; k < size; ++k) {
    Real* __restrict const column = transposed + k * TILE;
    for (int r = 0; r < TILE; ++r) column[r] = row_of[r][k];
  }
  for (int k = 0; k < (1 + sets.shown()) * TILE; ++k) out[k] = 0.0;
  // Products first: those of M are minus half the sum of phi times those of sigma.
  const Sparse& products = sets.pi_of_products;
  for (int p = products.columns - 1; p >= 0; --p) {
    Real product[TILE] = {};
    int k = products.first[p + 1] - 1;
    if (k < products.first[p] || products.row[k] < first) break;
    for (; k >= products.first[p] && products.row[k] >= first; --k)
      add(products.value[k], transposed + products.row[k] * TILE, product);
    const int a = sets.pair[2 * p], b = sets.pair[2 * p + 1];
    add(phi[b], product, out + (1 + a) * TILE);
    add(phi[a], product, out + (1 + b) * TILE);
  }
  for (int k = 0; k < sets.sigmas; ++k) add(Real(-0.5) * phi[k], out + (1 + k) * TILE, out);
  for (int c = 0; c < sets.shown(); ++c)
    for (int k = sets.pi_of_shown.first[c]; k < sets.pi_of_shown.first[c + 1]; ++k)
      if (sets.pi_of_shown.row[k] >= first)
        add(sets.pi_of_shown.value[k], transposed + sets.pi_of_shown.row[k] * TILE, out + c * TILE);
  Real* const rhs = out + sets.shown() * TILE;
  for (int r = 0; r < TILE; ++r) rhs[r] = row_of[r][size];
  for (int k = 0; k < sets.sigmas; ++k) {
    const int row = sets.pis + k;
    if (row < first) continue;
    add(1 / M_0, transposed + row * TILE, out + (1 + k) * TILE);
    add(-phi[k] / M_0, transposed + row * TILE, out);
    add(-phi[k], transposed + row * TILE, rhs);
  }
}

}  // namespace orbident
