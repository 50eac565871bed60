// How the unknowns that are no parameters change from sample to sample.
//
//   h_cm' = (integral of R_0) (b_g + n) x h_cm    where the attitude is integrated
//   v_cm' = (integral of R_0) b_a + white         where the velocity is
//   b_g' = white,   b_a' = white
//
// The axes in which momentum and velocity are known drift with the sensors; in these axes both are
// constant.
#pragma once

#include "orbident/conservation_equations.hpp"
#include "orbident/few_rows.hpp"

namespace orbident {

// U^-1 rows in place, from the last row up; U is upper triangular, n x n, and holds the inverses of
// its diagonal there.
ORBIDENT_FEW_WIDE inline void solve_upper(const double* U, int n, double* rows, int stride, int width) {
  for (int c = 0; c < width; c += LANES)
    for (int i = n - 1; i >= 0; --i) {
      double* __restrict const row = rows + i * stride + c;
      double own[LANES];
      const double inverse = U[i * n + i];
      for (int l = 0; l < LANES; ++l) own[l] = row[l] * inverse;
      for (int l = 0; l < LANES; ++l) row[l] = own[l];
      for (int r = 0; r < i; ++r) {
        double* __restrict const above = rows + r * stride + c;
        const double share = U[r * n + i];
        for (int l = 0; l < LANES; ++l) above[l] -= share * own[l];
      }
    }
}

// C = U U^T in place of C's upper triangle, with the inverses of U's diagonal.
inline void factor_upper(double* C, int n) {
  for (int i = n - 1; i >= 0; --i) {
    double rest = C[i * n + i];
    for (int k = i + 1; k < n; ++k) rest -= C[i * n + k] * C[i * n + k];
    const double inverse = 1.0 / std::sqrt(rest);
    C[i * n + i] = inverse;
    for (int r = 0; r < i; ++r) {
      double entry = C[r * n + i];
      for (int k = i + 1; k < n; ++k) entry -= C[r * n + k] * C[i * n + k];
      C[r * n + i] = entry * inverse;
    }
  }
}

// The rows [N | Y | z] of N x + Y y = z for the nuisances x = [h_cm, v_cm, b_g, b_a] a time dt later,
// N upper triangular before and after. With x_before = back x - kick w and w of unit variance they are
//
//   N back x + Y y = z + N kick w
//
// whitened: the noise of the right-hand side has the covariance 1 + K K^T = U U^T, K = N kick. N back
// and U are upper triangular, and so is U^-1 N back.
//
//   integral  of R_0 over dt
//   h_cm      the momentum known so far, N m s
//   K, C      room for n x n each
inline void predict_nuisances(const ConservationModel& model, double* top, int stride, int width,
                              const Matrix& integral, const Vector& h_cm, double dt, double* K,
                              double* C) {
  const ConservedAxes& axes = model.axes;
  const SensorNoise& noise = model.noise;
  const int n = model.nuisances(), b_g = model.gyro_bias(), b_a = model.accelerometer_bias();
  const int integrated = noise.accelerometer ? axes.velocities : 0;
  for (int k = 0; k < n * n; ++k) K[k] = 0.0;
  const auto walk = [&](double std, int unknown, int column, int count) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < count; ++j)
        K[i * n + column + j] = std * std::sqrt(dt) * top[i * stride + unknown + j];
  };
  walk(noise.velocity_walk, axes.momenta, axes.momenta, integrated);
  walk(noise.gyro_walk, b_g, b_g, axes.momenta);
  walk(noise.accelerometer_walk, b_a, b_a, integrated);
  for (int j = 0; j < axes.momenta; ++j) {
    const Vector turn = noise.integrated * Vector(integral.col(axes.momentum[j])).cross(h_cm);
    for (int i = 0; i < n; ++i) {
      double by_turn = 0.0;
      for (int k = 0; k < axes.momenta; ++k) by_turn += top[i * stride + k] * turn[axes.momentum[k]];
      top[i * stride + b_g + j] -= by_turn;
      K[i * n + j] = noise.gyro * by_turn;
    }
  }
  for (int j = 0; j < integrated; ++j)
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < axes.velocities; ++k)
        top[i * stride + b_a + j] -=
            top[i * stride + axes.momenta + k] * integral(axes.velocity[k], axes.velocity[j]);

  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) {
      // K's rows are zero before their diagonal, but for the turns.
      double sum = i == j ? 1.0 : 0.0;
      for (int k = j < axes.momenta ? 0 : j; k < n; ++k) sum += K[i * n + k] * K[j * n + k];
      C[i * n + j] = sum;
    }
  factor_upper(C, n);
  solve_upper(C, n, top, stride, width);
}

}  // namespace orbident
