// How likely samples are under a density of white snap (white_snap.hpp), the state at the start
// integrated out:
//
//   -2 log L = misfit / R + log_det + (n - 4) log R,   R the variance of the noise.
#pragma once

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
  double root[DENSITIES], left[DENSITIES];
  for (int l = 0; l < DENSITIES; ++l) root[l] = std::sqrt(density[l]);
  measure(x[0], known, left);
  double dt = 0.0;
  Motion step;
  for (std::ptrdiff_t k = 1; k < n; ++k) {
    if (t[k] - t[k - 1] != dt) step = motion(dt = t[k] - t[k - 1], 1.0);
    advance(step, root, known, noise);
    measure(x[k], known, left);
    for (int l = 0; l < DENSITIES; ++l) {
      double det = 1.0;
      for (int i = 0; i < ORDER; ++i) det *= noise[i][i][l];
      found.misfit[l] += left[l] * left[l];
      found.log_det[l] += 2 * std::log(std::abs(det));
    }
  }
  for (int l = 0; l < DENSITIES; ++l) {
    for (int i = 0; i < ORDER; ++i)
      found.log_det[l] += 2 * std::log(std::abs(known.rows[i][ORDER + i][l]));
  }
}

}  // namespace orbident
