// How likely samples are under a density of white snap (white_snap.hpp), the state at the start
// integrated out:
//
//   -2 log L = misfit / R + log_det + (n - 4) log R,   R the variance of the noise.
//
// The same square-root information filter for DENSITIES of them at once, each in a lane of its own: the
// rotations follow one another, and a processor has nothing else to do while it waits for their roots.
#pragma once

#include "orbident/householder.hpp"
#include "orbident/white_snap.hpp"

namespace orbident {

// As many as the widest vector has numbers.
constexpr int DENSITIES = LANES;

struct Evidence {
  double misfit[DENSITIES] = {}, log_det[DENSITIES] = {};
};

namespace evidence {

using white_snap::ORDER;

// A row has w, the state and the right side; a number of it has its lanes.
constexpr int STATE = ORDER, RIGHT = 2 * ORDER, WIDTH = RIGHT + 1;
using Row = double[WIDTH][DENSITIES];

// Givens: two equations turned so that b[k] vanishes; both are zero before k.
ORBIDENT_INLINE void turn(Row& __restrict a, Row& __restrict b, int k) {
  double c[DENSITIES], s[DENSITIES];
  for (int l = 0; l < DENSITIES; ++l) {
    const double norm = std::sqrt(a[k][l] * a[k][l] + b[k][l] * b[k][l]);
    // Where nothing is known yet, both stay as they are.
    const double none = norm > 0 ? 0.0 : 1.0, whole = norm + none;
    c[l] = (a[k][l] + none) / whole;
    s[l] = b[k][l] / whole;
  }
  for (int j = k; j < WIDTH; ++j)
    for (int l = 0; l < DENSITIES; ++l) {
      const double before = a[j][l];
      a[j][l] = c[l] * before + s[l] * b[j][l];
      b[j][l] = c[l] * b[j][l] - s[l] * before;
    }
}

// What a sample says of the state, folded into the triangle; what is left of it is misfit.
ORBIDENT_INLINE void measure(double y, Row (&known)[ORDER], Evidence& found) {
  Row sample = {};
  for (int l = 0; l < DENSITIES; ++l) {
    sample[STATE][l] = 1.0;
    sample[RIGHT][l] = y;
  }
#pragma GCC unroll 4
  for (int i = 0; i < ORDER; ++i) turn(known[i], sample, STATE + i);
  for (int l = 0; l < DENSITIES; ++l) found.misfit[l] += sample[RIGHT][l] * sample[RIGHT][l];
}

// One step: w = 0 + N(0, 1) and R (F^-1 s+ - G w) = z + N(0, 1), in which w is eliminated.
ORBIDENT_INLINE void advance(const white_snap::Motion<double>& step, const double* root_density,
                             Row (&known)[ORDER], Evidence& found) {
  Row noise[ORDER] = {};
#pragma GCC unroll 4
  for (int i = 0; i < ORDER; ++i) {
    Row before = {};
    for (int j = i; j < ORDER; ++j)
      for (int l = 0; l < DENSITIES; ++l) before[j][l] = known[i][STATE + j][l];
    for (int k = 0; k < ORDER; ++k)
      for (int l = 0; l < DENSITIES; ++l) {
        double by_w = 0.0, by_s = 0.0;
        for (int j = i; j < ORDER; ++j) {
          by_w += before[j][l] * step.G(j, k);
          if (j <= k) by_s += before[j][l] * step.F_inv(j, k);
        }
        known[i][k][l] = -by_w * root_density[l];
        known[i][STATE + k][l] = by_s;
      }
    for (int l = 0; l < DENSITIES; ++l) noise[i][i][l] = 1.0;
  }
  // In each column from the bottom row up, so that R F^-1 stays a triangle.
#pragma GCC unroll 4
  for (int d = 0; d < ORDER; ++d)
#pragma GCC unroll 4
    for (int i = 0; i + d < ORDER; ++i) turn(noise[i + d], known[i], i + d);
  for (int l = 0; l < DENSITIES; ++l) {
    double det = 1.0;
    for (int i = 0; i < ORDER; ++i) det *= noise[i][i][l];
    found.log_det[l] += 2 * std::log(std::abs(det));
  }
}

}  // namespace evidence

// Of n samples, for DENSITIES densities in units of the samples' noise and of time.
ORBIDENT_WIDEST inline void evidence_of(const double* t, const double* x, std::ptrdiff_t n,
                                        const double* density, Evidence& found) {
  using namespace evidence;
  Row known[ORDER] = {};
  double root_density[DENSITIES];
  for (int l = 0; l < DENSITIES; ++l) root_density[l] = std::sqrt(density[l]);
  measure(x[0], known, found);
  double dt = 0.0;
  white_snap::Motion<double> step;
  for (std::ptrdiff_t k = 1; k < n; ++k) {
    if (t[k] - t[k - 1] != dt) step = white_snap::motion(dt = t[k] - t[k - 1], 1.0);
    advance(step, root_density, known, found);
    measure(x[k], known, found);
  }
  for (int l = 0; l < DENSITIES; ++l)
    for (int i = 0; i < ORDER; ++i)
      found.log_det[l] += 2 * std::log(std::abs(known[i][STATE + i][l]));
}

}  // namespace orbident
