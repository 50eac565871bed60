// White noise beside what lasts, on one axis of a sensor: its innovations, for whole rows at once.
//
//   y = x_1 + x_2 + e,                e ~ N(0, sigma^2)
//   x_1(t + dt) = a x_1(t) + n,       a = exp(-dt / T),  n ~ N(0, s^2 (1 - a^2))   (Gauss-Markov)
//   x_2(t + dt) = x_2(t) + n,         n ~ N(0, q^2 dt)                             (random walk)
//
// The innovation of a sample is what its predecessors do not predict of it. Innovations are
// independent, so over their deviations they are white; and they are linear in the samples: a row
// of equations is whitened by the same filter as the sample that it is about (Kalman, 1960).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace orbident {

// The parts of an axis's noise that last; zero where there are none.
struct Coloured {
  double std, time, walk;  // s, T, q
  static constexpr int PARTS = 2;
  bool has(int part) const { return part == 0 ? std > 0.0 : walk > 0.0; }
  int parts() const { return int(has(0)) + int(has(1)); }
};

// The filter of one axis. Its means are rows, as wide as those it whitens: the caller's memory.
struct Whitening {
  static constexpr int PARTS = Coloured::PARTS;
  Coloured coloured;
  double t;                // of the means, s
  double P[PARTS][PARTS];  // their covariance
  double* mean[PARTS];
  int width;

  // Both parts are known: the means are what the caller writes, or zero.
  void start(const Coloured& noise, double at) {
    coloured = noise;
    t = at;
    for (int i = 0; i < PARTS; ++i) {
      std::fill_n(mean[i], width, 0.0);
      std::fill_n(P[i], PARTS, 0.0);
    }
  }

  // As it is before the first sample of a recording: the walk begins there.
  void start_stationary(const Coloured& noise, double at) {
    start(noise, at);
    P[0][0] = noise.std * noise.std;
  }

  void predict(double at) {
    const double dt = at - t;
    t = at;
    if (dt == 0.0) return;
    if (coloured.has(0)) {
      const double a = std::exp(-dt / coloured.time);
      for (int k = 0; k < width; ++k) mean[0][k] *= a;
      P[0][0] = a * a * P[0][0] - coloured.std * coloured.std * std::expm1(-2 * dt / coloured.time);
      P[0][1] *= a;
      P[1][0] = P[0][1];
    }
    P[1][1] += coloured.walk * coloured.walk * dt;
  }

  // The row becomes its innovation. Returns the variance of this.
  double innovate(double* row, double variance) {
    double by[PARTS];
    for (int i = 0; i < PARTS; ++i) by[i] = P[i][0] + P[i][1];
    const double S = by[0] + by[1] + variance;
    for (int k = 0; k < width; ++k) {
      row[k] -= mean[0][k] + mean[1][k];
      for (int i = 0; i < PARTS; ++i) mean[i][k] += by[i] / S * row[k];
    }
    for (int i = 0; i < PARTS; ++i)
      for (int j = 0; j < PARTS; ++j) P[i][j] -= by[i] * by[j] / S;
    return S;
  }
};

}  // namespace orbident
