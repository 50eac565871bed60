// How the unknowns that are no parameters change from sample to sample.
//
//   h_cm' = (integral of R_0) (b_g + n) x h_cm    where the attitude is integrated
//         + white                                 where torques act at random
//   v_cm' = (integral of R_0) b_a                 where the velocity is integrated
//         + white                                 there, and where forces act at random
//   b_g' = white,   b_a' = white
//   p'   = e + t - d qd - c sign(qd) - o + white        of driven joints (driven_joints.hpp)
//
// The axes in which momentum and velocity are known drift with the sensors; in these axes both are
// constant, but for what acts from outside.
#pragma once

#include "orbident/conservation_equations.hpp"
#include "orbident/householder.hpp"

namespace orbident {

// C = U U^T, U upper triangular, in place: row i of C, its lower triangle, becomes column i of U
// above the diagonal, and the inverse of U_ii.
ORBIDENT_WIDEST inline void factor_upper(Real* C, int n) {
  for (int i = n - 1; i >= 0; --i) {
    Real* __restrict const column = C + i * n;
    const Real inverse = 1 / std::sqrt(column[i]);
    column[i] = inverse;
    for (int r = 0; r < i; ++r) column[r] *= inverse;
    for (int k = 0; k < i; ++k) {
      Real* __restrict const left = C + k * n;
      const Real share = column[k];
      for (int r = 0; r <= k; ++r) left[r] -= share * column[r];
    }
  }
}

// U^-1 rows in place, from the last row up, with U as factor_upper leaves it.
ORBIDENT_WIDEST inline void solve_upper(const Real* U, int n, Real* rows, int stride, int width) {
  for (int i = n - 1; i >= 0; --i) {
    const Real* const column = U + i * n;
    Real* __restrict const row = rows + i * stride;
    const Real inverse = column[i];
    for (int c = 0; c < width; ++c) row[c] *= inverse;
    for (int r = 0; r < i; ++r) {
      Real* __restrict const above = rows + r * stride;
      const Real share = column[r];
      for (int c = 0; c < width; ++c) above[c] -= share * row[c];
    }
  }
}

// C = 1 + K K^T, its lower triangle; a row of `kicks` is what one source of noise does to all.
ORBIDENT_WIDEST inline void covariance_of(const Real* kicks, int count, int n, Real* C) {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) C[i * n + j] = i == j ? 1.0 : 0.0;
  for (int k = 0; k < count; ++k) {
    const Real* const kick = kicks + k * n;
    for (int i = 0; i < n; ++i) {
      Real* __restrict const row = C + i * n;
      const Real share = kick[i];
      if (share == 0) continue;
      for (int j = 0; j <= i; ++j) row[j] += share * kick[j];
    }
  }
}

// The rows [N | Y | z] of N x + Y y = z for the nuisances x = [h_cm, v_cm, b_g, b_a] a time dt
// later, N upper triangular before and after. With x_before = back x - kick w and w of unit
// variance they are
//
//   N back x + Y y = z + N kick w
//
// whitened: the noise of the right-hand side has the covariance 1 + K K^T = U U^T, K = N kick. N
// back and U are upper triangular, and so is U^-1 N back.
//
// Returns what unit noise of each axis of the gyro adds to the whitened rows: the columns of U^-1 K
// that are its own. They are zero but in the rows of h_cm, which come first in N.
//
//   integral  of R_0 over dt
//   h_cm      the momentum known so far, N m s
//   p_walk    deviations of what the momenta of driven joints gain, N m s
//   K, C      room for (n + momenta) x n and n x n; K's columns are stored as rows
inline Matrix predict_nuisances(const ConservationModel& model, Real* top, int stride, int width,
                                const Matrix& integral, const Vector& h_cm, Real dt,
                                const Real* p_walk, Real* K, Real* C) {
  const ConservedAxes& axes = model.axes;
  const SensorNoise& noise = model.noise;
  const int n = model.nuisances(), b_g = model.gyro_bias(), b_a = model.accelerometer_bias();
  const int integrated = noise.accelerometer ? axes.velocities : 0;
  const int kicks = n + axes.momenta;
  for (int k = 0; k < kicks * n; ++k) K[k] = 0.0;
  const auto kick = [&](Real std, int unknown) {
    for (int i = 0; i < n; ++i) K[unknown * n + i] = std * top[i * stride + unknown];
  };
  const auto walk = [&](Real std, int unknown, int column, int count) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < count; ++j)
        K[(column + j) * n + i] = std * std::sqrt(dt) * top[i * stride + unknown + j];
  };
  walk(noise.momentum_walk, 0, n, axes.momenta);
  walk(noise.velocity_walk, axes.momenta, axes.momenta, axes.velocities);
  for (int k = 0; k < model.driven.count; ++k) kick(p_walk[k], model.joint_momentum() + k);
  walk(noise.gyro_walk, b_g, b_g, axes.momenta);
  walk(noise.accelerometer_walk, b_a, b_a, integrated);
  for (int j = 0; j < axes.momenta; ++j) {
    const Vector turn = noise.integrated * Vector(integral.col(axes.momentum[j])).cross(h_cm);
    for (int i = 0; i < n; ++i) {
      Real by_turn = 0.0;
      for (int k = 0; k < axes.momenta; ++k)
        by_turn += top[i * stride + k] * turn[axes.momentum[k]];
      top[i * stride + b_g + j] -= by_turn;
      K[j * n + i] = noise.gyro * by_turn;
    }
  }
  for (int j = 0; j < integrated; ++j)
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < axes.velocities; ++k)
        top[i * stride + b_a + j] -=
            top[i * stride + axes.momenta + k] * integral(axes.velocity[k], axes.velocity[j]);

  covariance_of(K, kicks, n, C);
  factor_upper(C, n);
  solve_upper(C, n, top, stride, padded(width));
  Matrix of_gyro = Matrix::Zero();
  for (int j = 0; j < axes.momenta; ++j)
    for (int i = axes.momenta - 1; i >= 0; --i) {
      Real rest = K[j * n + i];
      for (int k = i + 1; k < axes.momenta; ++k) rest -= C[k * n + i] * of_gyro(k, j);
      of_gyro(i, j) = C[i * n + i] * rest;
    }
  return of_gyro;
}

}  // namespace orbident
