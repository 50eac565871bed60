// Rows folded into a triangular factor by Householder's reflections:
//
//   | R |         | R' |
//   | X |  =  Q   | 0  |
//
// Column j goes to its first entry by 1 - b u u^T, u = [R_jj +- norm, X_j]. Both tables are row-major.
// Columns of R before its diagonal are zero and stay so.
//
// Rows go in BLOCK by BLOCK, so that the loop over them is unrolled. Everything is a combination of
// whole rows: entry c of the result depends on columns c and j alone, in a fixed order, and a wider
// processor gives the same bits. Large rows belong into R before small ones: then rounding is relative
// to each row's own size (Powell and Reid, 1969).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

// Compiled for wider vectors too.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define ORBIDENT_WIDEST __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define ORBIDENT_WIDEST
#endif
#if defined(__GNUC__)
#define ORBIDENT_INLINE __attribute__((always_inline)) inline
#else
#define ORBIDENT_INLINE inline
#endif

namespace orbident {

// Doubles of the widest vector. Tables whose width is a multiple are folded fastest, and are best
// aligned to one.
constexpr int LANES = 8;

constexpr int padded(int width) { return (width + LANES - 1) / LANES * LANES; }

// Rows that are folded at once: with them, what the inner loop holds fits into 16 registers.
constexpr int BLOCK = 8;

// Squares between these neither lose digits nor overflow, and nor do their sums and products by b.
constexpr double SMALLEST_SQUARE = 1e-200, LARGEST_SQUARE = 1e200;
// A column below this is zero: rounding leaves 1e-16 of rows that are used up, and 1e-16 of that, and
// so on, down to numbers without all their digits.
constexpr double NOTHING = 1e-292;

// Reflects the columns of R_j and N rows from c on, as many blocks of L as fit before n; returns the
// column behind them.
template <int N, int L>
ORBIDENT_INLINE int reflect(double* R_j, double* X, std::ptrdiff_t stride, int c, int n, double v,
                            const double* u, double b) {
  for (; c + L <= n; c += L) {
    double* __restrict const pivot = R_j + c;
    double* __restrict const rows = X + c;
    // Two sums, of even and of odd rows: each waits for half as many additions.
    double share[L], odd[L] = {};
    for (int l = 0; l < L; ++l) share[l] = v * pivot[l];
#pragma GCC unroll 8
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < L; ++l) (i % 2 ? odd : share)[l] += u[i] * rows[i * stride + l];
    for (int l = 0; l < L; ++l) share[l] = b * (share[l] + odd[l]);
    for (int l = 0; l < L; ++l) pivot[l] -= v * share[l];
#pragma GCC unroll 8
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < L; ++l) rows[i * stride + l] -= u[i] * share[l];
  }
  return c;
}

template <int N>
ORBIDENT_INLINE void fold_block(double* R, std::ptrdiff_t R_stride, double* X, std::ptrdiff_t stride,
                                int n, int columns) {
  for (int j = 0; j < columns; ++j) {
    double* const R_j = R + j * R_stride;
    double u[N], a = R_j[j], scale = 1.0, squares[2] = {0.0, 0.0};
    for (int i = 0; i < N; ++i) {
      u[i] = X[i * stride + j];
      squares[i % 2] += u[i] * u[i];
    }
    double below = squares[0] + squares[1];
    if (!(below > SMALLEST_SQUARE && a * a + below < LARGEST_SQUARE)) {
      scale = 0.0;
      for (int i = 0; i < N; ++i) scale = std::max(scale, std::abs(u[i]));
      if (!(scale > NOTHING)) continue;
      scale = std::max(scale, std::abs(a));
      a /= scale;
      below = 0.0;
      for (int i = 0; i < N; ++i) {
        u[i] /= scale;
        below += u[i] * u[i];
      }
    }
    const double norm = std::sqrt(a * a + below);
    const double image = a >= 0.0 ? -norm : norm;
    const double v = a - image;
    const double b = 2.0 / (v * v + below);
    R_j[j] = 0.0;
    for (int i = 0; i < N; ++i) X[i * stride + j] = 0.0;
    const int rest = reflect<N, LANES>(R_j, X, stride, j / LANES * LANES, n, v, u, b);
    reflect<N, 1>(R_j, X, stride, rest, n, v, u, b);
    R_j[j] = scale * image;
  }
}

// Folds the m rows X of n columns into R: their first `columns` are brought to zero, and X keeps what
// is left of the others.
ORBIDENT_WIDEST inline void fold(double* R, std::ptrdiff_t R_stride, double* X, std::ptrdiff_t stride,
                                 int m, int n, int columns) {
  for (; m >= BLOCK; m -= BLOCK, X += BLOCK * stride)
    fold_block<BLOCK>(R, R_stride, X, stride, n, columns);
  switch (m) {
    case 1: return fold_block<1>(R, R_stride, X, stride, n, columns);
    case 2: return fold_block<2>(R, R_stride, X, stride, n, columns);
    case 3: return fold_block<3>(R, R_stride, X, stride, n, columns);
    case 4: return fold_block<4>(R, R_stride, X, stride, n, columns);
    case 5: return fold_block<5>(R, R_stride, X, stride, n, columns);
    case 6: return fold_block<6>(R, R_stride, X, stride, n, columns);
    case 7: return fold_block<7>(R, R_stride, X, stride, n, columns);
    default: return;
  }
}

}  // namespace orbident
