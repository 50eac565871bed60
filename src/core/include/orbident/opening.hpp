// The robot has changed: the estimate becomes the prior of what it is now.
//
// With beta' = beta + L w, w of unit variance, the covariance of beta' is R^-1 R^-T + L L^T. In
// square roots, with rows folded into a triangle G,
//
//   | R^-T |         | G |
//   | L^T  |  =  Q   | 0 |         root = G^-T,   root^T root = (R^-1 R^-T + L L^T)^-1
#pragma once

#include "orbident/triangles.hpp"

namespace orbident {

// Of the caller's memory that `open_up` needs.
constexpr long opening_numbers(const FilterSizes& size) {
  return 2L * size.betas() * padded(size.betas());
}

// From time t on; the nuisances keep their values, and are hardly known.
//   L       betas x betas, in the order of beta
//   tables  opening_numbers of them
inline void open_up(const FilterModel& model, FilterState& state, Real t, const Real* L,
                    Real* tables, FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const int k = size.betas(), width = padded(k), stride = size.beta_stride();
  const long numbers = static_cast<long>(k) * width;
  Real *const G = tables, *const rows = tables + numbers;
  const auto in_beta = [&](int i) { return i < size.iotas ? size.shown + i : i - size.iotas; };
  for (long i = 0; i < 2 * numbers; ++i) tables[i] = 0;
  // Columns of R^-1, each as a row.
  Real* const column = room.beta;
  for (int j = 0; j < k; ++j) {
    for (int i = j; i >= 0; --i) {
      const Real* const row = state.root + static_cast<long>(i) * stride;
      column[i] = (Real(i == j) - dot(row + i + 1, column + i + 1, j - i)) / row[i];
      rows[j * width + in_beta(i)] = column[i];
    }
  }
  fold(G, width, rows, width, k, width, k);
  for (int j = 0; j < k; ++j)
    for (int i = 0; i < width; ++i) rows[j * width + i] = i < k ? L[i * k + j] : Real(0);
  fold(G, width, rows, width, k, width, k);
  Real* const root = rows;
  for (int i = 0; i < k; ++i) {
    for (int c = 0; c < k; ++c) root[i * k + c] = Real(i == c);
    for (int j = 0; j < i; ++j)
      for (int c = 0; c <= j; ++c) root[i * k + c] -= G[j * width + i] * root[j * k + c];
    for (int c = 0; c <= i; ++c) root[i * k + c] /= G[i * width + i];
  }
  // `begin` writes to the state what it reads of it here.
  const Matrix R_WB = Eigen::Map<const Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>>(state.R_WB);
  begin(model, t, R_WB, state.beta, root, state.x, state, room);
}

}  // namespace orbident
