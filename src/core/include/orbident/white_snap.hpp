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

#include <cmath>

#include "orbident/householder.hpp"

namespace orbident::white_snap {

// Components of the state. With 3, white jerk, the natural end conditions cost the rate at the ends
// of noise-free data three digits, and rates of smooth motion are three times noisier.
constexpr int ORDER = 4;

// Equations, one a row, as [coefficients | right side]: columns of w, of s, and the right side.
// Each number stands for N columns or densities, side by side: rotations follow one another, and a
// processor has nothing else to do while it waits for their roots.
constexpr int RIGHT = 2 * ORDER, WIDTH = RIGHT + 1;
template <int N>
using Row = double[WIDTH][N];
template <int N>
using Triangle = Row<N>[ORDER];
template <int N>
using Square = double[ORDER][ORDER][N];

// What the samples so far say of the state: R s = z + N(0, 1) in the columns of s, R upper
// triangular; zero where nothing is known.
template <int N>
struct Information {
  Triangle<N> rows = {};
};

// The state given all samples: its mean and covariance.
template <int N>
struct Estimate {
  double mean[ORDER][N];
  Square<N> covariance;
};

// F(dt)^-1 = F(-dt), of which the first row is kept, and G = F^-1 B, which is upper triangular.
template <int N>
struct Motion {
  double F_inv[ORDER][N];
  Square<N> G;
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
template <int N>
ORBIDENT_INLINE void motion(const double (&dt)[N], const double (&density)[N], Motion<N>& step) {
  constexpr UnitNoise unit;
  ORBIDENT_LANES
  for (int l = 0; l < N; ++l) {
    double power = 1.0, scale = std::sqrt(density[l] * dt[l]);
    for (int k = 0; k < ORDER; ++k) {
      const int i = ORDER - 1 - k;
      step.F_inv[k][l] = power / factorial(k);
      power *= -dt[l];
      for (int j = i; j < ORDER; ++j) step.G[i][j][l] = unit.G[i][j] * scale;
      scale *= dt[l];
    }
  }
}

// Givens: two equations turned so that b[k] vanishes; both are zero before k.
template <int N>
ORBIDENT_INLINE void turn(Row<N>& __restrict a, Row<N>& __restrict b, int k) {
  double c[N], s[N];
  ORBIDENT_LANES
  for (int l = 0; l < N; ++l) {
    const double norm = std::sqrt(a[k][l] * a[k][l] + b[k][l] * b[k][l]);
    // Where nothing is known yet, both stay as they are.
    const double none = norm > 0 ? 0.0 : 1.0, whole = norm + none;
    c[l] = (a[k][l] + none) / whole;
    s[l] = b[k][l] / whole;
  }
  for (int j = k; j < WIDTH; ++j) ORBIDENT_LANES
  for (int l = 0; l < N; ++l) {
    const double before = a[j][l];
    a[j][l] = c[l] * before + s[l] * b[j][l];
    b[j][l] = c[l] * b[j][l] - s[l] * before;
  }
}

// Moves by one step: w = 0 + N(0, 1) and R (F^-1 s+ - G w) = z + N(0, 1), in which w is eliminated.
// Leaves the equations U w + T s+ = b + N(0, 1) that hold w, U upper triangular, in `noise`.
template <int N>
ORBIDENT_INLINE void advance(const Motion<N>& step, Information<N>& known, Triangle<N>& noise) {
  Triangle<N>& rows = known.rows;
#pragma GCC unroll 4
  for (int i = 0; i < ORDER; ++i) {
    Row<N> R = {};
    for (int j = i; j < ORDER; ++j) ORBIDENT_LANES
    for (int l = 0; l < N; ++l) R[j][l] = rows[i][ORDER + j][l];
    for (int k = 0; k < ORDER; ++k) ORBIDENT_LANES
    for (int l = 0; l < N; ++l) {
      double by_w = 0.0, by_s = 0.0;
      for (int j = i; j <= k; ++j) {
        by_w += R[j][l] * step.G[j][k][l];
        by_s += R[j][l] * step.F_inv[k - j][l];
      }
      rows[i][k][l] = -by_w;
      rows[i][ORDER + k][l] = by_s;
    }
    for (int k = 0; k < WIDTH; ++k) ORBIDENT_LANES
    for (int l = 0; l < N; ++l) noise[i][k][l] = k == i ? 1.0 : 0.0;
  }
  // In each column from the bottom row up, so that R F^-1 stays a triangle; in this order, diagonal
  // by diagonal, rotations that follow one another are independent, and a processor overlaps them.
#pragma GCC unroll 4
  for (int d = 0; d < ORDER; ++d)
#pragma GCC unroll 4
    for (int i = 0; i + d < ORDER; ++i) turn<N>(noise[i + d], rows[i], i + d);
}

// Takes in a sample, x = y + N(0, 1), where `seen` is 1; where it is 0, there is none. What it
// leaves unexplained is in `left`.
template <int N>
ORBIDENT_INLINE void measure(const double (&y)[N], const double (&seen)[N], Information<N>& known,
                             double (&left)[N]) {
  Row<N> sample = {};
  ORBIDENT_LANES
  for (int l = 0; l < N; ++l) {
    sample[ORDER][l] = seen[l];
    sample[RIGHT][l] = y[l];
  }
#pragma GCC unroll 4
  for (int i = 0; i < ORDER; ++i) turn<N>(known.rows[i], sample, ORDER + i);
  ORBIDENT_LANES
  for (int l = 0; l < N; ++l) left[l] = sample[RIGHT][l];
}

// From the state after a step to the state before it: s = F^-1 s+ - G w with
// w = U^-1 (b - T s+ + N(0, 1)). The mean alone takes two thirds of the time.
template <bool WITH_COVARIANCE, int N>
ORBIDENT_INLINE void retreat(const Motion<N>& step, const Triangle<N>& noise, Estimate<N>& at) {
  // U^-1 [1 T b].
  Triangle<N> X;
#pragma GCC unroll 4
  for (int i = ORDER - 1; i >= 0; --i) {
    for (int c = WITH_COVARIANCE ? i : ORDER; c < WIDTH; ++c) ORBIDENT_LANES
    for (int l = 0; l < N; ++l) {
      double x = c == i ? 1.0 : c < ORDER ? 0.0 : noise[i][c][l];
      for (int k = i + 1; k < ORDER && (c >= ORDER || k <= c); ++k)
        x -= noise[i][k][l] * X[k][c][l];
      X[i][c][l] = x / noise[i][i][l];
    }
  }
  // s = L s+ - g + V N(0, 1).
  Square<N> L;
  double mean[ORDER][N];
#pragma GCC unroll 4
  for (int i = 0; i < ORDER; ++i) ORBIDENT_LANES
  for (int l = 0; l < N; ++l) {
    for (int c = 0; c < ORDER; ++c) {
      double by_s = 0.0;
      for (int k = i; k < ORDER; ++k) by_s += step.G[i][k][l] * X[k][ORDER + c][l];
      L[i][c][l] = c < i ? by_s : step.F_inv[c - i][l] + by_s;
    }
    mean[i][l] = 0.0;
    for (int k = 0; k < ORDER; ++k) mean[i][l] += L[i][k][l] * at.mean[k][l];
    for (int k = i; k < ORDER; ++k) mean[i][l] -= step.G[i][k][l] * X[k][RIGHT][l];
  }
  for (int i = 0; i < ORDER; ++i) ORBIDENT_LANES
  for (int l = 0; l < N; ++l) at.mean[i][l] = mean[i][l];
  if constexpr (WITH_COVARIANCE) {
    Square<N> V, PLT;
    for (int i = 0; i < ORDER; ++i) ORBIDENT_LANES
    for (int l = 0; l < N; ++l) {
      for (int c = i; c < ORDER; ++c) {
        V[i][c][l] = 0.0;
        for (int k = i; k <= c; ++k) V[i][c][l] += step.G[i][k][l] * X[k][c][l];
      }
      for (int c = 0; c < ORDER; ++c) {
        PLT[i][c][l] = 0.0;
        for (int k = 0; k < ORDER; ++k) PLT[i][c][l] += at.covariance[i][k][l] * L[c][k][l];
      }
    }
    for (int i = 0; i < ORDER; ++i) ORBIDENT_LANES
    for (int l = 0; l < N; ++l)
      for (int c = i; c < ORDER; ++c) {
        double sum = 0.0;
        for (int k = 0; k < ORDER; ++k) sum += L[i][k][l] * PLT[k][c][l];
        for (int k = c; k < ORDER; ++k) sum += V[i][k][l] * V[c][k][l];
        at.covariance[i][c][l] = at.covariance[c][i][l] = sum;
      }
  }
}

// The last state from all that is known, R^-1 z and (R^T R)^-1, of column l.
template <int N>
inline void final_estimate(const Information<N>& known, int l, Estimate<N>& at) {
  // R^-1 [1 z].
  double X[ORDER][ORDER + 1] = {};
  for (int i = ORDER - 1; i >= 0; --i) {
    X[i][i] = 1.0;
    X[i][ORDER] = known.rows[i][RIGHT][l];
    for (int c = i; c <= ORDER; ++c) {
      for (int k = i + 1; k < ORDER; ++k) X[i][c] -= known.rows[i][ORDER + k][l] * X[k][c];
      X[i][c] /= known.rows[i][ORDER + i][l];
    }
  }
  for (int i = 0; i < ORDER; ++i) {
    at.mean[i][l] = X[i][ORDER];
    for (int c = 0; c < ORDER; ++c) {
      at.covariance[i][c][l] = 0.0;
      for (int k = 0; k < ORDER; ++k) at.covariance[i][c][l] += X[i][k] * X[c][k];
    }
  }
}

}  // namespace orbident::white_snap
