// When did the robot change? The generalised likelihood ratio of the innovations.
//
// While nothing changes, whitened innovations are independent with zero mean. A capture, a release
// or a loss gives them a mean, unknown and from an unknown sample on; twice the logarithm of the
// likelihood ratio is then (Willsky and Jones 1976; Basseville and Nikiforov 1993, section 4.4)
//
//   g = max over j of |white_j + ... + white_k|^2 / (k - j + 1)
//
// and each of its terms is chi-square with as many degrees of freedom as there are rows.
#pragma once

#include <cmath>

#include "orbident/scalar.hpp"

namespace orbident {

// What a detector remembers: sums of innovations up to each of the last samples. The caller's
// memory.
struct Watch {
  int rows;     // of an innovation
  int window;   // samples that the onset may lie back
  Real* sums;   // window + 1 x rows
  Real* times;  // window + 1: of the sample after each sum, s; NaN where there was none
};

struct Likelihood {
  Real g;
  Real onset;  // the first sample of the change, most likely, s
};

inline void watch_nothing(Watch& watch) {
  for (int k = 0; k < (watch.window + 1) * watch.rows; ++k) watch.sums[k] = 0.0;
  for (int k = 0; k <= watch.window; ++k) watch.times[k] = NOT_A_NUMBER;
}

// Takes the whitened innovation of time t in; its entries are `stride` apart.
inline Likelihood watch_one(Watch& watch, Real t, const Real* white, int stride) {
  const int rows = watch.rows, window = watch.window;
  Real* const now = watch.sums + window * rows;
  for (int k = 0; k < window * rows; ++k) watch.sums[k] = watch.sums[k + rows];
  for (int k = 0; k < window; ++k) watch.times[k] = watch.times[k + 1];
  for (int i = 0; i < rows; ++i) now[i] += white[i * stride];
  watch.times[window - 1] = t;
  watch.times[window] = NOT_A_NUMBER;
  Likelihood most{0.0, t};
  for (int j = 0; j < window; ++j) {
    if (std::isnan(watch.times[j])) continue;
    Real square = 0.0;
    for (int i = 0; i < rows; ++i) {
      const Real sum = now[i] - watch.sums[j * rows + i];
      square += sum * sum;
    }
    const Real g = square / static_cast<Real>(window - j);
    if (g > most.g) most = {g, watch.times[j]};
  }
  return most;
}

}  // namespace orbident
