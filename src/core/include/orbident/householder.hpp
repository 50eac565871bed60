// Rows folded into a triangular factor by Householder's reflections:
//
//   | R |         | R' |
//   | X |  =  Q   | 0  |
//
// Column j goes to its first entry by 1 - b u u^T, u = [R_jj +- norm, X_j]. Both tables are
// row-major. Columns of R before its diagonal are zero and stay so.
//
// Rows go in BLOCK by BLOCK, so that the loop over them is unrolled. Everything is a combination of
// whole rows: entry c of the result depends on columns c and j alone, in a fixed order, and a wider
// processor gives the same bits. Large rows belong into R before small ones: then rounding is
// relative to each row's own size (Powell and Reid, 1969).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "orbident/scalar.hpp"

// Compiled for wider vectors too, unless a flight build says otherwise.
#if defined(ORBIDENT_WIDEST)
#elif defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define ORBIDENT_WIDEST __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define ORBIDENT_WIDEST
#endif
// Short loops are copied into every caller and unrolled, unless little code is asked for (-Os).
#if defined(__GNUC__) && !defined(__OPTIMIZE_SIZE__)
#define ORBIDENT_INLINED __attribute__((always_inline))
#define ORBIDENT_INLINE ORBIDENT_INLINED inline
#define ORBIDENT_UNROLLED _Pragma("GCC unroll 8")
#else
#define ORBIDENT_INLINED
#define ORBIDENT_INLINE inline
#define ORBIDENT_UNROLLED
#endif

// One number of each column or density: before it is unrolled, such a loop becomes a vector's.
#if defined(__GNUC__)
#define ORBIDENT_LANES _Pragma("omp simd")
#else
#define ORBIDENT_LANES
#endif

namespace orbident {

// Numbers of the widest vector: 8 of double. Tables whose width is a multiple are folded fastest,
// and are best aligned to one.
constexpr int LANES = 8;

constexpr int padded(int width) { return (width + LANES - 1) / LANES * LANES; }

// Rows that are folded at once: with them, what the inner loop holds fits into 16 registers.
constexpr int BLOCK = 8;

// What a scalar can hold.
template <class T>
struct Range;
template <>
struct Range<double> {
  // Squares between these neither lose digits nor overflow; nor do their sums and products by b.
  static constexpr double SMALLEST_SQUARE = 1e-200, LARGEST_SQUARE = 1e200;
  // A column below this is zero: rounding leaves 1e-16 of rows that are used up, and 1e-16 of that,
  // and so on, down to numbers without all their digits.
  static constexpr double NOTHING = 1e-292;
};
template <>
struct Range<float> {
  static constexpr float SMALLEST_SQUARE = 1e-24f, LARGEST_SQUARE = 1e24f, NOTHING = 1e-31f;
};

template <int N>
using Rows = std::integral_constant<int, N>;

// Reflects the columns of R_j and `count` rows from c on, as many blocks of L as fit before n;
// returns the column behind them. The compiler knows `count`, or does not.
template <int L, class Count>
ORBIDENT_INLINE int reflect(Real* R_j, Real* X, std::ptrdiff_t stride, Count count, int c, int n,
                            Real v, const Real* u, Real b) {
  const int N = count;
  for (; c + L <= n; c += L) {
    Real* __restrict const pivot = R_j + c;
    Real* __restrict const rows = X + c;
    // Two sums, of even and of odd rows: each waits for half as many additions.
    Real share[L], odd[L] = {};
    for (int l = 0; l < L; ++l) share[l] = v * pivot[l];
    ORBIDENT_UNROLLED
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < L; ++l) (i % 2 ? odd : share)[l] += u[i] * rows[i * stride + l];
    for (int l = 0; l < L; ++l) share[l] = b * (share[l] + odd[l]);
    for (int l = 0; l < L; ++l) pivot[l] -= v * share[l];
    ORBIDENT_UNROLLED
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < L; ++l) rows[i * stride + l] -= u[i] * share[l];
  }
  return c;
}

template <class Count>
ORBIDENT_INLINE void fold_block(Real* R, std::ptrdiff_t R_stride, Real* X, std::ptrdiff_t stride,
                                Count count, int n, int columns) {
  const int N = count;
  for (int j = 0; j < columns; ++j) {
    Real* const R_j = R + j * R_stride;
    Real u[BLOCK], a = R_j[j], scale = 1.0, squares[2] = {0.0, 0.0};
    for (int i = 0; i < N; ++i) {
      u[i] = X[i * stride + j];
      squares[i % 2] += u[i] * u[i];
    }
    Real below = squares[0] + squares[1];
    if (!(below > Range<Real>::SMALLEST_SQUARE && a * a + below < Range<Real>::LARGEST_SQUARE)) {
      scale = 0.0;
      for (int i = 0; i < N; ++i) scale = std::max(scale, std::abs(u[i]));
      if (!(scale > Range<Real>::NOTHING)) continue;
      scale = std::max(scale, std::abs(a));
      a /= scale;
      below = 0.0;
      for (int i = 0; i < N; ++i) {
        u[i] /= scale;
        below += u[i] * u[i];
      }
    }
    const Real norm = std::sqrt(a * a + below);
    const Real image = a >= 0 ? -norm : norm;
    const Real v = a - image;
    const Real b = 2 / (v * v + below);
    R_j[j] = 0.0;
    for (int i = 0; i < N; ++i) X[i * stride + j] = 0.0;
    [[maybe_unused]] const int rest =
        reflect<LANES>(R_j, X, stride, count, j / LANES * LANES, n, v, u, b);
#ifndef ORBIDENT_SMALL
    reflect<1>(R_j, X, stride, count, rest, n, v, u, b);
#endif
    R_j[j] = scale * image;
  }
}

// Folds the m rows X of n columns into R: their first `columns` are brought to zero, and X keeps
// what is left of the others. All tables of the filter have a multiple of LANES columns, and a
// build for it (ORBIDENT_SMALL) is for such alone.
ORBIDENT_WIDEST inline void fold(Real* R, std::ptrdiff_t R_stride, Real* X, std::ptrdiff_t stride,
                                 int m, int n, int columns) {
#ifdef ORBIDENT_SMALL
  // The same sums in the same order, in a tenth of the code.
  for (; m > 0; m -= BLOCK, X += BLOCK * stride)
    fold_block(R, R_stride, X, stride, m < BLOCK ? m : BLOCK, n, columns);
#else
  for (; m >= BLOCK; m -= BLOCK, X += BLOCK * stride)
    fold_block(R, R_stride, X, stride, Rows<BLOCK>(), n, columns);
  switch (m) {
    case 1:
      return fold_block(R, R_stride, X, stride, Rows<1>(), n, columns);
    case 2:
      return fold_block(R, R_stride, X, stride, Rows<2>(), n, columns);
    case 3:
      return fold_block(R, R_stride, X, stride, Rows<3>(), n, columns);
    case 4:
      return fold_block(R, R_stride, X, stride, Rows<4>(), n, columns);
    case 5:
      return fold_block(R, R_stride, X, stride, Rows<5>(), n, columns);
    case 6:
      return fold_block(R, R_stride, X, stride, Rows<6>(), n, columns);
    case 7:
      return fold_block(R, R_stride, X, stride, Rows<7>(), n, columns);
    default:
      return;
  }
#endif
}

}  // namespace orbident
