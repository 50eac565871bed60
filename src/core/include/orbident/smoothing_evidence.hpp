// How likely samples are under a density of white snap (white_snap.hpp), the state at the start
// integrated out:
//
//   -2 log L = misfit / R + log_det + (n - 4) log R,   R the variance of the noise.
#pragma once

#include <algorithm>

#include "orbident/white_snap.hpp"

namespace orbident {

// Densities that are weighed at once: as many as the widest vector has numbers.
constexpr int DENSITIES = LANES;

struct Evidence {
  double misfit[DENSITIES] = {}, log_det[DENSITIES] = {};
};

// Of n samples, for DENSITIES densities in units of the samples' noise and of time.
ORBIDENT_WIDEST inline void evidence_of(const double* t, const double* x, std::ptrdiff_t n,
                                        const double* density, Evidence& found) {
  using namespace white_snap;
  Information<DENSITIES> known;
  Triangle<DENSITIES> noise;
  Motion<DENSITIES> step;
  double densities[DENSITIES], dt[DENSITIES], seen[DENSITIES], y[DENSITIES], left[DENSITIES];
  std::copy_n(density, DENSITIES, densities);
  std::fill_n(seen, DENSITIES, 1.0);
  std::fill_n(y, DENSITIES, x[0]);
  measure(y, seen, known, left);
  for (std::ptrdiff_t k = 1; k < n; ++k) {
    std::fill_n(dt, DENSITIES, t[k] - t[k - 1]);
    std::fill_n(y, DENSITIES, x[k]);
    motion(dt, densities, step);
    advance(step, known, noise);
    measure(y, seen, known, left);
    ORBIDENT_LANES
    for (int l = 0; l < DENSITIES; ++l) {
      double det = 1.0;
      for (int i = 0; i < ORDER; ++i) det *= noise[i][i][l];
      found.misfit[l] += left[l] * left[l];
      found.log_det[l] += 2 * std::log(std::abs(det));
    }
  }
  ORBIDENT_LANES
  for (int l = 0; l < DENSITIES; ++l) {
    for (int i = 0; i < ORDER; ++i)
      found.log_det[l] += 2 * std::log(std::abs(known.rows[i][ORDER + i][l]));
  }
}

}  // namespace orbident
