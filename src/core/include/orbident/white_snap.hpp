// A position driven by white snap and measured in noise: one least-squares problem, step by step.
//
// The state s = (x, x', x'', x''') moves by s+ = F s + B w, w ~ N(0, 1), and a sample shows
// y = x + N(0, 1): the unit is the standard deviation of the measurement, and `density` is the
// spectral density of x'''' in that unit, squared, and the unit of time. The posterior mean is the
// smoothing spline of degree 7 (Wahba 1978).
//
// All unknowns (w_1 .. w_n, s_n) solve one sparse least-squares problem, whose QR factors are found
// step by step (square-root information filter; Bierman 1977, chapters V and X). No covariance is
// inverted or subtracted, so nothing at all need be known at the start, gaps may be long, and the
// samples may be free of noise but for rounding.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "orbident/householder.hpp"

namespace orbident::white_snap {

// Components of the state. With 3, white jerk, the natural end conditions cost the rate at the ends
// of noise-free data three digits, and rates of smooth motion are three times noisier.
constexpr int ORDER = 4;

using State = Eigen::Matrix<double, ORDER, 1>;
using Square = Eigen::Matrix<double, ORDER, ORDER>;

// Equations, one a row, as [coefficients | right side]: columns of w, of s, and the right side. Each
// number stands for N densities, side by side: rotations follow one another, and a processor has
// nothing else to do while it waits for their roots.
constexpr int RIGHT = 2 * ORDER, WIDTH = RIGHT + 1;
template <int N>
using Row = double[WIDTH][N];
template <int N>
using Triangle = Row<N>[ORDER];
// Those of one density.
using SnapRows = Eigen::Matrix<double, ORDER, WIDTH, Eigen::RowMajor>;

// What the samples so far say of the state: R s = z + N(0, 1) in the columns of s, R upper
// triangular; zero where nothing is known.
template <int N>
struct Information {
  Triangle<N> rows = {};
};

// The state given all samples: its mean and covariance.
struct Estimate {
  State mean;
  Square covariance;
};

// F(dt)^-1 = F(-dt), and G = F^-1 B.
struct Motion {
  Square F_inv, G;
};

constexpr double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

// sqrt(2k+1): norms of Legendre's polynomials.
constexpr double LEGENDRE[ORDER] = {1.0, 1.7320508075688772, 2.23606797749979, 2.6457513110645907};

struct UnitNoise {
  double G[ORDER][ORDER] = {};
  constexpr UnitNoise() {
    for (int p = 0; p < ORDER; ++p)
      for (int k = 0; k <= p; ++k)
        G[ORDER - 1 - p][ORDER - 1 - k] = ((p + k) % 2 ? -1.0 : 1.0) * LEGENDRE[k] * factorial(p) /
                                          (factorial(p - k) * factorial(p + k + 1));
  }
};

// F_ij = dt^(j-i) / (j-i)!. The noise adds int u^p / p! dW to component i, p = 3 - i, u the time
// left, and in the orthonormal polynomials of the step (Legendre's), k = 3 - j,
//
//   B_ij = dt^p sqrt(density dt) sqrt(2k+1) p! / ((p-k)! (p+k+1)!),   G_ij = (-1)^(i+j) B_ij:
//
// seen from the end of the step, the odd polynomials change their sign.
inline Motion motion(double dt, double density) {
  constexpr UnitNoise unit;
  Motion step;
  step.F_inv.setZero();
  double power = 1.0, scale = std::sqrt(density * dt);
  for (int k = 0; k < ORDER; ++k) {
    const int i = ORDER - 1 - k;
    step.F_inv.diagonal(k).setConstant(power / factorial(k));
    power *= -dt;
    for (int j = 0; j < ORDER; ++j) step.G(i, j) = unit.G[i][j] * scale;
    scale *= dt;
  }
  return step;
}

// Givens: two equations turned so that b[k] vanishes; both are zero before k.
template <int N>
ORBIDENT_INLINE void turn(Row<N>& __restrict a, Row<N>& __restrict b, int k) {
  double c[N], s[N];
  for (int l = 0; l < N; ++l) {
    const double norm = std::sqrt(a[k][l] * a[k][l] + b[k][l] * b[k][l]);
    // Where nothing is known yet, both stay as they are.
    const double none = norm > 0 ? 0.0 : 1.0, whole = norm + none;
    c[l] = (a[k][l] + none) / whole;
    s[l] = b[k][l] / whole;
  }
  for (int j = k; j < WIDTH; ++j)
    for (int l = 0; l < N; ++l) {
      const double before = a[j][l];
      a[j][l] = c[l] * before + s[l] * b[j][l];
      b[j][l] = c[l] * b[j][l] - s[l] * before;
    }
}

// Moves by one step: w = 0 + N(0, 1) and R (F^-1 s+ - root G w) = z + N(0, 1), in which w is
// eliminated; `root` multiplies the noise of each density. Leaves the equations
// U w + T s+ = b + N(0, 1) that hold w, U upper triangular, in `noise`.
template <int N>
ORBIDENT_INLINE void advance(const Motion& step, const double (&root)[N], Information<N>& known,
                             Triangle<N>& noise) {
  Triangle<N>& rows = known.rows;
#pragma GCC unroll 4
  for (int i = 0; i < ORDER; ++i) {
    Row<N> R = {};
    for (int j = i; j < ORDER; ++j)
      for (int l = 0; l < N; ++l) R[j][l] = rows[i][ORDER + j][l];
    for (int k = 0; k < ORDER; ++k)
      for (int l = 0; l < N; ++l) {
        double by_w = 0.0, by_s = 0.0;
        for (int j = i; j < ORDER; ++j) {
          by_w += R[j][l] * step.G(j, k);
          if (j <= k) by_s += R[j][l] * step.F_inv(j, k);
        }
        rows[i][k][l] = -by_w * root[l];
        rows[i][ORDER + k][l] = by_s;
      }
    for (int k = 0; k < WIDTH; ++k)
      for (int l = 0; l < N; ++l) noise[i][k][l] = k == i ? 1.0 : 0.0;
  }
  // In each column from the bottom row up, so that R F^-1 stays a triangle; in this order, diagonal
  // by diagonal, rotations that follow one another are independent, and a processor overlaps them.
#pragma GCC unroll 4
  for (int d = 0; d < ORDER; ++d)
#pragma GCC unroll 4
    for (int i = 0; i + d < ORDER; ++i) turn<N>(noise[i + d], rows[i], i + d);
}

// Takes in a sample, x = y + N(0, 1); what it leaves unexplained is in `left`.
template <int N>
ORBIDENT_INLINE void measure(double y, Information<N>& known, double (&left)[N]) {
  Row<N> sample = {};
  for (int l = 0; l < N; ++l) {
    sample[ORDER][l] = 1.0;
    sample[RIGHT][l] = y;
  }
#pragma GCC unroll 4
  for (int i = 0; i < ORDER; ++i) turn<N>(known.rows[i], sample, ORDER + i);
  for (int l = 0; l < N; ++l) left[l] = sample[RIGHT][l];
}

// From the state after a step to the state before it: s = F^-1 s+ - G w with
// w = U^-1 (b - T s+ + N(0, 1)).
inline void retreat(const Motion& step, const SnapRows& noise, Estimate& at) {
  // U^-1 [1 T b].
  SnapRows X = noise;
  X.leftCols<ORDER>().setIdentity();
  for (int i = ORDER - 1; i >= 0; --i) {
    for (int k = i + 1; k < ORDER; ++k) X.row(i) -= noise(i, k) * X.row(k);
    X.row(i) /= noise(i, i);
  }
  const Square N = step.G * X.leftCols<ORDER>();
  const Square L = step.F_inv + step.G * X.middleCols<ORDER>(ORDER);
  const State g = step.G * X.col(RIGHT);
  const Square PLT = at.covariance * L.transpose();
  at.mean = (L * at.mean - g).eval();
  at.covariance.noalias() = L * PLT;
  at.covariance.noalias() += N * N.transpose();
}

// The last state from all that is known: R^-1 z and (R^T R)^-1.
inline Estimate final_estimate(const Information<1>& known) {
  const Eigen::Map<const SnapRows> rows(known.rows[0][0]);
  const auto R = rows.middleCols<ORDER>(ORDER);
  Square inverse = Square::Identity();
  State mean = rows.col(RIGHT);
  for (int i = ORDER - 1; i >= 0; --i) {
    for (int k = i + 1; k < ORDER; ++k) {
      inverse.row(i) -= R(i, k) * inverse.row(k);
      mean[i] -= R(i, k) * mean[k];
    }
    inverse.row(i) /= R(i, i);
    mean[i] /= R(i, i);
  }
  return {mean, inverse * inverse.transpose()};
}

}  // namespace orbident::white_snap
