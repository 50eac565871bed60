// Three rows as a 3 x 3 matrix times three rows: what is linear in the changes of all unknowns.
//
// Every sum is in the same order on any processor.
#pragma once

#include "orbident/householder.hpp"
#include "orbident/rotations.hpp"

namespace orbident {

// to += by x rows, both of n columns; rows may be `to` itself.
ORBIDENT_WIDEST inline void add_combined(const Matrix3<double>& by, const double* rows,
                                         std::ptrdiff_t stride, int n, double* to,
                                         std::ptrdiff_t to_stride) {
  const Matrix3<double> A = by;  // of which nothing is written to
  const double *const p = rows, *const q = rows + stride, *const r = rows + 2 * stride;
  double *const x = to, *const y = to + to_stride, *const z = to + 2 * to_stride;
  ORBIDENT_LANES
  for (int c = 0; c < n; ++c) {
    const double u = p[c], v = q[c], w = r[c];
    x[c] += A(0, 0) * u + A(0, 1) * v + A(0, 2) * w;
    y[c] += A(1, 0) * u + A(1, 1) * v + A(1, 2) * w;
    z[c] += A(2, 0) * u + A(2, 1) * v + A(2, 2) * w;
  }
}

// to += a x, of so many numbers.
ORBIDENT_WIDEST inline void add_scaled(double a, const double* x, int count, double* to) {
  const double* __restrict const from = x;
  double* __restrict const sum = to;
  ORBIDENT_LANES
  for (int c = 0; c < count; ++c) sum[c] += a * from[c];
}

// to += by x table, where `by` is of so many rows and inner columns; the table and the result are
// of n columns. Four of its rows at once: the result is read and written a quarter as often.
ORBIDENT_WIDEST inline void add_product(const double* by, int rows, int inner, const double* table,
                                        int n, double* to) {
  for (int r = 0; r < rows; ++r) {
    double* __restrict const sum = to + r * n;
    const double* a = by + r * inner;
    const double* p = table;
    int left = inner;
    for (; left >= 4; left -= 4, a += 4, p += 4 * n) {
      const double *const q = p + n, *const u = p + 2 * n, *const v = p + 3 * n;
      ORBIDENT_LANES
      for (int c = 0; c < n; ++c) sum[c] += a[0] * p[c] + a[1] * q[c] + a[2] * u[c] + a[3] * v[c];
    }
    for (; left > 0; --left, ++a, p += n) {
      ORBIDENT_LANES
      for (int c = 0; c < n; ++c) sum[c] += a[0] * p[c];
    }
  }
}

// A table of three rows of n columns, as a sum.
class CombinedRows {
 public:
  CombinedRows(double* to, int n) : to_(to), n_(n) {}
  CombinedRows& zero() {
    std::fill_n(to_, 3 * std::ptrdiff_t(n_), 0.0);
    return *this;
  }
  CombinedRows& add(const Matrix3<double>& by, const double* rows) {
    add_combined(by, rows, n_, n_, to_, n_);
    return *this;
  }

 private:
  double* to_;
  int n_;
};

}  // namespace orbident
