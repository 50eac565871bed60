// Forward-mode derivatives: a number with its derivatives in N directions, exact to rounding.
//
//   f(a + v e) = f(a) + f'(a) v e,   e^2 = 0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace orbident {

template <int N>
struct Jet {
  using Derivatives = Eigen::Array<double, N, 1, Eigen::DontAlign>;
  double a = 0.0;
  Derivatives v = Derivatives::Zero();

  Jet() = default;
  Jet(double value) : a(value) {}
  Jet(double value, const Derivatives& derivatives) : a(value), v(derivatives) {}

  Jet operator-() const { return {-a, -v}; }
  Jet& operator+=(const Jet& b) { return a += b.a, v += b.v, *this; }
  Jet& operator-=(const Jet& b) { return a -= b.a, v -= b.v, *this; }
  Jet& operator*=(const Jet& b) { return v = v * b.a + a * b.v, a *= b.a, *this; }
  Jet& operator/=(const Jet& b) { return *this = *this / b; }
  friend Jet operator+(const Jet& x, const Jet& y) { return {x.a + y.a, x.v + y.v}; }
  friend Jet operator-(const Jet& x, const Jet& y) { return {x.a - y.a, x.v - y.v}; }
  friend Jet operator*(const Jet& x, const Jet& y) { return {x.a * y.a, x.v * y.a + x.a * y.v}; }
  friend Jet operator/(const Jet& x, const Jet& y) {
    const double q = x.a / y.a;
    return {q, (x.v - q * y.v) / y.a};
  }
  friend bool operator<(const Jet& x, const Jet& y) { return x.a < y.a; }
  friend bool operator>(const Jet& x, const Jet& y) { return x.a > y.a; }
  friend bool operator==(const Jet& x, const Jet& y) { return x.a == y.a; }
};

template <int N>
Jet<N> sin(const Jet<N>& x) {
  return {std::sin(x.a), std::cos(x.a) * x.v};
}
template <int N>
Jet<N> cos(const Jet<N>& x) {
  return {std::cos(x.a), -std::sin(x.a) * x.v};
}
template <int N>
Jet<N> sqrt(const Jet<N>& x) {
  const double root = std::sqrt(x.a);
  return {root, x.v / (2.0 * root)};
}

}  // namespace orbident

namespace Eigen {
template <int N>
struct NumTraits<orbident::Jet<N>> : NumTraits<double> {
  using Real = orbident::Jet<N>;
  using NonInteger = orbident::Jet<N>;
  using Nested = orbident::Jet<N>;
  enum { RequireInitialization = 1, ReadCost = N + 1, AddCost = N + 1, MulCost = 3 * N };
};
}  // namespace Eigen
