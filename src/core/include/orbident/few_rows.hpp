// Householder reflections that take three to eight rows into a triangular factor: what a step of the
// filter waits for. householder.hpp folds tables of many rows, in strips of columns, and scales each
// column; here the rows are whitened, and the loop over them is unrolled.
//
//   Q [R; rows] = [R'; 0],   R and R' upper triangular
//
// Column j goes to its first entry by 1 - b u u^T, u = [R_jj +- norm, rows_j]. Every step is a
// combination of rows: entry c of the result depends on columns c and j alone, in a fixed order, so
// that its last bit does not depend on the width of the processor's vectors.
//
// Rows lie at a distance of `stride` entries. Behind their width they hold zeros up to a multiple of
// LANES, so that loops run over whole blocks.
#pragma once

#include <cmath>

namespace orbident {

constexpr int LANES = 4;

constexpr int padded(int width) { return (width + LANES - 1) / LANES * LANES; }

// Rows of a block, filled up with zeros: what the loops keep in registers.
constexpr int BLOCK = 8;

// A squared column below this is zero: rounding leaves 1e-16 of rows that are used up, and 1e-16 of
// that, and so on, down to where squares underflow.
constexpr double UNDERFLOW_SQUARED = 1e-200;

// Compiled for wider vectors too; the results are the same to the last bit.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define ORBIDENT_FEW_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define ORBIDENT_FEW_WIDE
#endif
#if defined(__GNUC__)
#define ORBIDENT_FEW_INLINE __attribute__((always_inline)) inline
#else
#define ORBIDENT_FEW_INLINE inline
#endif

// Reflects the columns from j on of R_j and N rows.
template <int N>
ORBIDENT_FEW_INLINE void reflect_few(double* R_j, int j, int width, double v, double b, const double* u,
                             double* rows, int row_stride) {
  double u_[N];
  for (int i = 0; i < N; ++i) u_[i] = u[i];
  // Columns before j are zero: blocks may begin there.
  for (int c = j / LANES * LANES; c < width; c += LANES) {
    double* __restrict const R_c = R_j + c;
    double* __restrict const rows_c = rows + c;
    // Two sums, of even and of odd rows: each waits for half as many additions.
    double share[LANES], odd[LANES] = {};
    for (int l = 0; l < LANES; ++l) share[l] = v * R_c[l];
#pragma GCC unroll 8
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < LANES; ++l)
        (i % 2 ? odd : share)[l] += u_[i] * rows_c[i * row_stride + l];
    for (int l = 0; l < LANES; ++l) share[l] += odd[l];
    for (int l = 0; l < LANES; ++l) share[l] *= b;
    for (int l = 0; l < LANES; ++l) R_c[l] -= v * share[l];
#pragma GCC unroll 8
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < LANES; ++l) rows_c[i * row_stride + l] -= u_[i] * share[l];
  }
}

// Takes 3, 6 or BLOCK rows into R until their first `columns` columns are zero; all in
// place. What is left of the rows keeps its directions.
ORBIDENT_FEW_WIDE inline void fold_few(double* R, int stride, int columns, int width, double* rows,
                               int row_stride, int count) {
  double u[BLOCK];
  for (int j = 0; j < columns; ++j) {
    double* const R_j = R + j * stride;
    double squares[2] = {0.0, 0.0};
    for (int i = 0; i < count; ++i) {
      u[i] = rows[i * row_stride + j];
      squares[i % 2] += u[i] * u[i];
    }
    const double below = squares[0] + squares[1];
    if (below < UNDERFLOW_SQUARED) continue;
    const double norm = std::sqrt(R_j[j] * R_j[j] + below);
    const double image = R_j[j] >= 0.0 ? -norm : norm;
    const double v = R_j[j] - image;
    const double b = 2.0 / (v * v + below);
    R_j[j] = 0.0;
    for (int i = 0; i < count; ++i) rows[i * row_stride + j] = 0.0;
    if (count == 6)
      reflect_few<6>(R_j, j, width, v, b, u, rows, row_stride);
    else if (count == BLOCK)
      reflect_few<BLOCK>(R_j, j, width, v, b, u, rows, row_stride);
    else
      reflect_few<3>(R_j, j, width, v, b, u, rows, row_stride);
    R_j[j] = image;
  }
}

// x . y in four sums of every fourth entry: a fixed order that vectors of any width keep.
inline double dot(const double* x, const double* y, int n) {
  double sums[4] = {0.0, 0.0, 0.0, 0.0};
  int k = 0;
  for (; k + 4 <= n; k += 4)
    for (int l = 0; l < 4; ++l) sums[l] += x[k + l] * y[k + l];
  for (; k < n; ++k) sums[0] += x[k] * y[k];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace orbident
