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
