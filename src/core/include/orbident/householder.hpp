// Rows folded into a triangular factor by Householder's reflections:
//
//   | R |         | R' |
//   | X |  =  Q   | 0  |
//
// Both tables are row-major. The zeros that R has below its diagonal are left alone. Everything is a
// combination of whole rows, one column beside the other, so a wider processor gives the same bits.
// Large rows belong into R before small ones: then rounding is relative to each row's own size
// (Powell and Reid, 1969).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#if defined(__GNUC__) && defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#define ORBIDENT_WIDEST __attribute__((target_clones("avx2", "default")))
#else
#define ORBIDENT_WIDEST
#endif
#if defined(__GNUC__)
#define ORBIDENT_INLINE __attribute__((always_inline)) inline
#else
#define ORBIDENT_INLINE inline
#endif

namespace orbident {

// Rows that are folded at once stay in the first-level cache: so many numbers of them.
constexpr int FOLDED_NUMBERS = 3072;

// X -= v tau (pivot + v^T X), pivot -= tau (pivot + v^T X), for as many strips of W columns as fit
// between the columns `first` and n; returns the column after them. A strip's sums stay in registers.
template <int W>
ORBIDENT_INLINE int reflect_strips(double* pivot, double* X, std::ptrdiff_t stride, int first, int n,
                                   const double* v, int m, double tau) {
  for (; first + W <= n; first += W) {
    double sum[W];
    for (int k = 0; k < W; ++k) sum[k] = pivot[first + k];
    for (int i = 0; i < m; ++i) {
      const double* row = X + i * stride + first;
      for (int k = 0; k < W; ++k) sum[k] += v[i] * row[k];
    }
    for (int k = 0; k < W; ++k) sum[k] *= tau;
    for (int k = 0; k < W; ++k) pivot[first + k] -= sum[k];
    for (int i = 0; i < m; ++i) {
      double* row = X + i * stride + first;
      for (int k = 0; k < W; ++k) row[k] -= v[i] * sum[k];
    }
  }
  return first;
}

// One reflection, by the vector [1, v] and its factor tau, of the n columns of a pivot row and of
// the m rows X.
ORBIDENT_WIDEST inline void reflect(double* pivot, double* X, std::ptrdiff_t stride, int n,
                                    const double* v, int m, double tau) {
  int first = reflect_strips<32>(pivot, X, stride, 0, n, v, m, tau);
  first = reflect_strips<24>(pivot, X, stride, first, n, v, m, tau);
  first = reflect_strips<16>(pivot, X, stride, first, n, v, m, tau);
  first = reflect_strips<8>(pivot, X, stride, first, n, v, m, tau);
  reflect_strips<1>(pivot, X, stride, first, n, v, m, tau);
}

// The same for any scalar.
template <class T>
void reflect(T* pivot, T* X, std::ptrdiff_t stride, int n, const T* v, int m, T tau) {
  for (int k = 0; k < n; ++k) {
    T sum = pivot[k];
    for (int i = 0; i < m; ++i) sum += v[i] * X[i * stride + k];
    sum *= tau;
    pivot[k] -= sum;
    for (int i = 0; i < m; ++i) X[i * stride + k] -= v[i] * sum;
  }
}

// Tables whose columns are a multiple of this are folded fastest.
constexpr int ALIGNED = 8;

// How many rows of n columns are folded at once, and how many numbers v must hold.
constexpr int rows_at_once(int n) { return std::max(1, FOLDED_NUMBERS / std::max(n, 1)); }

// Folds at most rows_at_once(n) rows.
template <class T>
void fold_block(T* R, std::ptrdiff_t R_stride, T* X, std::ptrdiff_t stride, int m, int n,
                int columns, T* v) {
  // Columns with nothing but smaller numbers hold nothing.
  const T least = std::numeric_limits<T>::min() / std::numeric_limits<T>::epsilon();
  for (int j = 0; j < columns; ++j) {
    T* pivot = R + j * R_stride + j;
    T largest = T(0);
    for (int i = 0; i < m; ++i) largest = std::max(largest, std::abs(X[i * stride + j]));
    if (!(largest > least)) continue;
    // Scaled, so that no square underflows or overflows.
    const T scale = std::max(largest, std::abs(*pivot));
    const T a = *pivot / scale;
    T squares = T(0);
    for (int i = 0; i < m; ++i) {
      v[i] = X[i * stride + j] / scale;
      squares += v[i] * v[i];
    }
    const T norm = std::copysign(std::sqrt(a * a + squares), a);
    const T first = a + norm;
    for (int i = 0; i < m; ++i) {
      v[i] /= first;
      X[i * stride + j] = T(0);
    }
    // Columns to the left are zero and stay so: whole strips from one of them on leave no rest.
    const int start = (j + 1) / ALIGNED * ALIGNED;
    *pivot = T(0);
    reflect(R + j * R_stride + start, X + start, stride, n - start, v, m, first / norm);
    *pivot = -norm * scale;
  }
}

// Folds the rows X (m x n) into R (upper triangular, n columns): their first `columns` are brought
// to zero, and X keeps what is left of the others. v is memory for rows_at_once(n) numbers.
template <class T>
void fold(T* R, std::ptrdiff_t R_stride, T* X, std::ptrdiff_t stride, int m, int n, int columns,
          T* v) {
  const int at_once = rows_at_once(n);
  for (int i = 0; i < m; i += at_once)
    fold_block(R, R_stride, X + i * stride, stride, std::min(at_once, m - i), n, columns, v);
}

}  // namespace orbident
