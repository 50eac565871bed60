// White noise beside what lasts, on one axis of a sensor: its innovations, for whole rows at once.
//
//   y = x_1 + x_2 + x_3 + e,          e ~ N(0, sigma^2)
//   x_1(t + dt) = a x_1(t) + n,       a = exp(-dt / T),  n ~ N(0, s^2 (1 - a^2))   (Gauss-Markov)
//   x_2(t + dt) = x_2(t) + n,         n ~ N(0, q^2 dt)                             (random walk)
//   x_3' = x_4,  x_4' = white, of the density p                       (a rate that walks)
//
// The innovation of a sample is what its predecessors do not predict of it. Innovations are
// independent, so over their deviations they are white; and they are linear in the samples: a row
// of equations is whitened by the same filter as the sample that it is about (Kalman, 1960).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace orbident {

constexpr int OFFSET = 2;  // the part whose rate walks

// The parts of an axis's noise that last; zero where there are none.
struct Coloured {
  double std, time, walk, rate_walk;          // s, T, q, p
  static constexpr int PARTS = 4, SHOWN = 3;  // the last is the rate of the one before it
  bool has(int part) const {
    return part == 0 ? std > 0.0 : part == 1 ? walk > 0.0 : rate_walk > 0.0;
  }
  int parts() const { return int(has(0)) + int(has(1)) + 2 * int(has(2)); }
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
    const auto on = [this](int to, double by, int from, double own) {
      for (int k = 0; k < PARTS; ++k) P[to][k] = own * P[to][k] + by * P[from][k];
      for (int k = 0; k < PARTS; ++k) P[k][to] = own * P[k][to] + by * P[k][from];
      for (int k = 0; k < width; ++k) mean[to][k] = own * mean[to][k] + by * mean[from][k];
    };
    if (coloured.has(0)) {
      on(0, 0.0, 0, std::exp(-dt / coloured.time));
      P[0][0] -= coloured.std * coloured.std * std::expm1(-2 * dt / coloured.time);
    }
    P[1][1] += coloured.walk * coloured.walk * dt;
    if (coloured.has(2)) {
      on(2, dt, 3, 1.0);
      const double p = coloured.rate_walk * coloured.rate_walk * dt;
      P[2][2] += p * dt * dt / 3;
      P[2][3] += p * dt / 2;
      P[3][2] += p * dt / 2;
      P[3][3] += p;
    }
  }

  // The row becomes its innovation. Returns the variance of this.
  double innovate(double* row, double variance) {
    double by[PARTS], S = variance;
    for (int i = 0; i < PARTS; ++i) by[i] = P[i][0] + P[i][1] + P[i][2];
    for (int i = 0; i < Coloured::SHOWN; ++i) {
      S += by[i];
      for (int k = 0; coloured.has(i) && k < width; ++k) row[k] -= mean[i][k];
    }
    for (int i = 0; i < PARTS; ++i)
      for (int k = 0; coloured.has(i) && k < width; ++k) mean[i][k] += by[i] / S * row[k];
    for (int i = 0; i < PARTS; ++i)
      for (int j = 0; j < PARTS; ++j) P[i][j] -= by[i] * by[j] / S;
    return S;
  }
};

}  // namespace orbident
