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

namespace orbident::white_snap {

// Components of the state. With 3, white jerk, the natural end conditions cost the rate at the ends
// of noise-free data three digits, and rates of smooth motion are three times noisier.
constexpr int ORDER = 4;

template <class T>
using State = Eigen::Matrix<T, ORDER, 1>;
template <class T>
using Square = Eigen::Matrix<T, ORDER, ORDER>;

// Equations, one a row, as [coefficients | right side]: columns of w, of s, and the right side. One
// more column, always zero, lets a processor take two at a time.
constexpr int RIGHT = 2 * ORDER, WIDTH = RIGHT + 2;
template <class T>
using SnapRows = Eigen::Matrix<T, ORDER, WIDTH, Eigen::RowMajor>;
template <class T>
using Equation = Eigen::Matrix<T, 1, WIDTH>;

// What the samples so far say of the state.
template <class T>
struct Information {
  // R s = z + N(0, 1) in the columns of s, R upper triangular; zero where nothing is known.
  SnapRows<T> rows = SnapRows<T>::Zero();
};

// The state given all samples: its mean and covariance.
template <class T>
struct Estimate {
  State<T> mean;
  Square<T> covariance;
};

// F(dt)^-1 = F(-dt), and G = F^-1 B.
template <class T>
struct Motion {
  Square<T> F_inv, G;
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
template <class T>
Motion<T> motion(const T& dt, const T& density) {
  using std::sqrt;
  constexpr UnitNoise unit;
  Motion<T> step;
  step.F_inv.setZero();
  T power = T(1), scale = sqrt(density * dt);
  for (int k = 0; k < ORDER; ++k) {
    const int i = ORDER - 1 - k;
    step.F_inv.diagonal(k).setConstant(power / T(factorial(k)));
    power *= -dt;
    for (int j = 0; j < ORDER; ++j) step.G(i, j) = T(unit.G[i][j]) * scale;
    scale *= dt;
  }
  return step;
}

// Givens: two equations turned so that b[k] vanishes.
template <class RowA, class RowB>
void turn(RowA&& a, RowB&& b, int k) {
  using std::sqrt;
  const auto norm = sqrt(a[k] * a[k] + b[k] * b[k]);
  if (!(norm > 0)) return;
  const auto c = a[k] / norm, s = b[k] / norm;
  const auto before = a.eval();
  a = c * before + s * b;
  b = c * b - s * before;
  b[k] = 0;
}

// Moves by one step: w = 0 + N(0, 1) and R (F^-1 s+ - G w) = z + N(0, 1), in which w is eliminated.
// Returns the equations U w + T s+ = b + N(0, 1) that hold w, U upper triangular.
template <class T>
SnapRows<T> advance(const Motion<T>& step, Information<T>& known) {
  SnapRows<T>& rows = known.rows;
  SnapRows<T> noise = SnapRows<T>::Zero();
  noise.template leftCols<ORDER>().setIdentity();
  const Square<T> R = rows.template middleCols<ORDER>(ORDER);
  rows.template leftCols<ORDER>().noalias() = -(R * step.G);
  rows.template middleCols<ORDER>(ORDER).noalias() = R * step.F_inv;
  // In each column from the bottom row up, so that R F^-1 stays a triangle; in this order, diagonal
  // by diagonal, rotations that follow one another are independent, and a processor overlaps them.
  for (int d = 0; d < ORDER; ++d)
    for (int i = 0; i + d < ORDER; ++i) turn(noise.row(i + d), rows.row(i), i + d);
  return noise;
}

// Takes in a sample: x = y + N(0, 1).
template <class T>
void measure(const T& y, Information<T>& known) {
  Equation<T> sample = Equation<T>::Zero();
  sample[ORDER] = T(1);
  sample[RIGHT] = y;
  for (int i = 0; i < ORDER; ++i) turn(known.rows.row(i), sample, ORDER + i);
}

// From the state after a step to the state before it: s = F^-1 s+ - G w with
// w = U^-1 (b - T s+ + N(0, 1)).
template <class T>
void retreat(const Motion<T>& step, const SnapRows<T>& noise, Estimate<T>& at) {
  // U^-1 [1 T b].
  SnapRows<T> X = noise;
  X.template leftCols<ORDER>().setIdentity();
  for (int i = ORDER - 1; i >= 0; --i) {
    for (int k = i + 1; k < ORDER; ++k) X.row(i) -= noise(i, k) * X.row(k);
    X.row(i) /= noise(i, i);
  }
  const Square<T> N = step.G * X.template leftCols<ORDER>();
  const Square<T> L = step.F_inv + step.G * X.template middleCols<ORDER>(ORDER);
  const State<T> g = step.G * X.col(RIGHT);
  const Square<T> PLT = at.covariance * L.transpose();
  at.mean = (L * at.mean - g).eval();
  at.covariance.noalias() = L * PLT;
  at.covariance.noalias() += N * N.transpose();
}

// The last state from all that is known: R^-1 z and (R^T R)^-1.
template <class T>
Estimate<T> final_estimate(const Information<T>& known) {
  const auto R = known.rows.template middleCols<ORDER>(ORDER);
  Square<T> inverse = Square<T>::Identity();
  State<T> mean = known.rows.col(RIGHT);
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
