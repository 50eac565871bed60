// The rows of a sample become rows with noise of unit variance.
//
// Where the attitude is the integrated gyro, the noise n of a rate also turns the axes in which
// momentum is known. Then rows of the sample and of the nuisances have noise in common:
//
//   rows of the sample:     G n + e,   G = [D; -U] times the deviation of n
//   rows of the nuisances:  K n + v,   whose sum has unit variance
//
// What the second say of the first, S = G K^T, is taken away: S times the second from the first,
// S S^T from the covariance of their noise. In one turn of the base the axes drift by as much as
// the rate is wrong, and without this errors are a tenth larger.
//
// The noise of momentum and velocity equation counts as independent beside that: what they share
// depends on D and U, which are wrong by some ten percent at first.
#pragma once

#include "orbident/conservation_equations.hpp"

namespace orbident {

// C^-1/2 rows in place, by Cholesky's factor of C over the given axes.
inline void whiten(const Matrix& C, const int* axis, int count, Real* rows, int stride, int width) {
  Matrix L = Matrix::Zero();
  for (int i = 0; i < count; ++i) {
    Real* const row = rows + i * stride;
    for (int j = 0; j < i; ++j) {
      Real rest = C(axis[i], axis[j]);
      for (int k = 0; k < j; ++k) rest -= L(i, k) * L(j, k);
      L(i, j) = rest / L(j, j);
      for (int c = 0; c < width; ++c) row[c] -= L(i, j) * rows[j * stride + c];
    }
    Real rest = C(axis[i], axis[i]);
    for (int k = 0; k < i; ++k) rest -= L(i, k) * L(i, k);
    L(i, i) = std::sqrt(rest);
    const Real inverse = 1 / L(i, i);
    for (int c = 0; c < width; ++c) row[c] *= inverse;
  }
}

// One law's rows, `count` of them along the given axes.
//
//   of_gyro  K, of the first rows of `top`, as predict_nuisances returns it
//   top      the rows of the nuisances, with the same columns
inline void whiten_law(const LawNoise& noise, const int* axis, int count, const Matrix& of_gyro,
                       int momenta, const Real* top, int top_stride, Real* rows, int stride,
                       int width) {
  const Matrix S = noise.of_gyro * of_gyro.transpose();
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < momenta; ++k) {
      const Real share = S(axis[i], k);
      const Real* const shared = top + k * top_stride;
      Real* const row = rows + i * stride;
      for (int c = 0; c < width; ++c) row[c] -= share * shared[c];
    }
  const Matrix C = noise.of_others + noise.of_gyro * noise.of_gyro.transpose() - S * S.transpose();
  whiten(C, axis, count, rows, stride, width);
}

}  // namespace orbident
