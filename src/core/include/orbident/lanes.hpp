// Several samples at once: a number of each in one vector register.
//
// Every lane has the operations of a double in the same order: its results are those of a double,
// to the last bit, whatever is in the other lanes.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace orbident {

struct Lanes {
  // Doubles in a vector register that every x86-64 and every 64-bit ARM processor has.
  static constexpr int COUNT = 2;
  using Numbers = Eigen::Array<double, COUNT, 1>;
  Numbers v;

  Lanes() = default;
  Lanes(double value) : v(Numbers::Constant(value)) {}
  template <class Expression>
  explicit Lanes(const Eigen::ArrayBase<Expression>& numbers) : v(numbers) {}

  Lanes operator-() const { return Lanes(-v); }
  Lanes& operator+=(const Lanes& b) { return v += b.v, *this; }
  Lanes& operator-=(const Lanes& b) { return v -= b.v, *this; }
  Lanes& operator*=(const Lanes& b) { return v *= b.v, *this; }
  Lanes& operator/=(const Lanes& b) { return v /= b.v, *this; }
  friend Lanes operator+(const Lanes& x, const Lanes& y) { return Lanes(x.v + y.v); }
  friend Lanes operator-(const Lanes& x, const Lanes& y) { return Lanes(x.v - y.v); }
  friend Lanes operator*(const Lanes& x, const Lanes& y) { return Lanes(x.v * y.v); }
  friend Lanes operator/(const Lanes& x, const Lanes& y) { return Lanes(x.v / y.v); }
};

inline Lanes sin(const Lanes& x) {
  Lanes y;
  for (int k = 0; k < Lanes::COUNT; ++k) y.v[k] = std::sin(x.v[k]);
  return y;
}

inline Lanes cos(const Lanes& x) {
  Lanes y;
  for (int k = 0; k < Lanes::COUNT; ++k) y.v[k] = std::cos(x.v[k]);
  return y;
}

// The next samples of those before `end`, one a lane; beyond the end, the last one again.
struct Group {
  std::ptrdiff_t first, end;
  std::ptrdiff_t sample(int lane) const { return std::min(first + lane, end - 1); }

  // From a table with so many numbers a sample.
  void load(const double* table, std::ptrdiff_t numbers, Lanes* x) const {
    for (int lane = 0; lane < Lanes::COUNT; ++lane) {
      const double* row = table + numbers * sample(lane);
      for (std::ptrdiff_t j = 0; j < numbers; ++j) x[j].v[lane] = row[j];
    }
  }
  // Into such a table, by write(place, value): as many numbers of a sample at once as there are
  // lanes.
  template <class Write>
  void store(const Lanes* x, std::ptrdiff_t numbers, double* table, Write&& write) const {
    const std::ptrdiff_t vectors = numbers % Lanes::COUNT ? 0 : numbers;
    for (int lane = 0; lane < Lanes::COUNT; ++lane) {
      double* row = table + numbers * sample(lane);
      for (std::ptrdiff_t j = 0; j < vectors; j += Lanes::COUNT) {
        Lanes::Numbers next;
        for (int k = 0; k < Lanes::COUNT; ++k) next[k] = x[j + k].v[lane];
        write(row + j, next);
      }
      for (std::ptrdiff_t j = vectors; j < numbers; ++j) write(row + j, x[j].v[lane]);
    }
  }
};

}  // namespace orbident

namespace Eigen {
template <>
struct NumTraits<orbident::Lanes> : NumTraits<double> {
  using Real = orbident::Lanes;
  using NonInteger = orbident::Lanes;
  using Nested = orbident::Lanes;
};
}  // namespace Eigen
