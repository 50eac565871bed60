// Whole columns through white_snap.hpp: what they most likely were.
#pragma once

#include <algorithm>
#include <limits>

#include "orbident/forward_and_back.hpp"
#include "orbident/white_snap.hpp"

namespace orbident {

// Columns that are smoothed at once: as many as most processors' vectors have numbers.
constexpr int SIDE_BY_SIDE = 4;

// The samples of one column: NaN on a row without one.
struct SampledColumn {
  const double* x;
  // Between two rows of x, whose columns lie side by side.
  std::ptrdiff_t stride;
  // Units of time (s) and noise, and what is taken off the samples.
  double h, noise_std, offset;
  // Spectral density of the snap in these units.
  double density;

  bool sampled(std::ptrdiff_t k) const { return !std::isnan(x[k * stride]); }
};

// One value a row of the column. What follows the rate is null where nobody asks for it.
struct SmoothedColumn {
  double* x;
  double* rate;
  double* acceleration;
  double* std_x;
  double* std_rate;
};

// The smoothing splines of columns at n common times t, each from its first to its last sample; NaN
// beyond. A column has the same operations in the same order whatever is beside it: its results are
// the same to the last bit.
template <bool WITH_COVARIANCE>
ORBIDENT_INLINE void smooth_lanes(const double* t, std::ptrdiff_t n, const SampledColumn* columns,
                                  const SmoothedColumn* out) {
  using namespace white_snap;
  constexpr int N = SIDE_BY_SIDE;
  double h[N], density[N];
  std::ptrdiff_t first[N], last[N];
  for (int l = 0; l < N; ++l) {
    h[l] = columns[l].h;
    density[l] = columns[l].density;
    first[l] = 0;
    last[l] = n - 1;
    while (first[l] < n && !columns[l].sampled(first[l])) ++first[l];
    while (last[l] >= 0 && !columns[l].sampled(last[l])) --last[l];
  }
  struct Left {
    Triangle<N> noise;
  };
  Motion<N> step;
  const auto move = [&](std::ptrdiff_t k) ORBIDENT_INLINED {
    double dt[N];
    ORBIDENT_LANES
    for (int l = 0; l < N; ++l) dt[l] = (t[k] - t[k - 1]) / h[l];
    motion(dt, density, step);
  };
  Estimate<N> at = {}, at_last = {};
  // Before its first sample nothing is known of a column, and the step leaves it so.
  const auto forward = [&](std::ptrdiff_t k, Information<N>& known) ORBIDENT_INLINED {
    Left left;
    if (k > 0) {
      move(k);
      advance(step, known, left.noise);
    }
    double y[N], seen[N], unexplained[N];
    for (int l = 0; l < N; ++l) {
      const bool sampled = columns[l].sampled(k);
      seen[l] = sampled ? 1.0 : 0.0;
      y[l] = sampled ? columns[l].x[k * columns[l].stride] - columns[l].offset : 0.0;
    }
    measure(y, seen, known, unexplained);
    for (int l = 0; l < N; ++l)
      if (k == last[l]) final_estimate(known, l, at_last);
    return left;
  };
  const auto back = [&](std::ptrdiff_t k, const Left& left) ORBIDENT_INLINED {
    for (int l = 0; l < N; ++l) {
      if (k == last[l]) {
        for (int i = 0; i < ORDER; ++i) {
          at.mean[i][l] = at_last.mean[i][l];
          for (int c = 0; c < ORDER; ++c) at.covariance[i][c][l] = at_last.covariance[i][c][l];
        }
      }
      const SampledColumn& column = columns[l];
      const SmoothedColumn& to = out[l];
      if (first[l] <= k && k <= last[l]) {
        to.x[k] = at.mean[0][l] + column.offset;
        to.rate[k] = at.mean[1][l] / h[l];
        if constexpr (WITH_COVARIANCE) {
          to.acceleration[k] = at.mean[2][l] / (h[l] * h[l]);
          to.std_x[k] = column.noise_std * std::sqrt(at.covariance[0][0][l]);
          to.std_rate[k] = column.noise_std * std::sqrt(at.covariance[1][1][l]) / h[l];
        }
      } else {
        for (double* value : {to.x, to.rate, to.acceleration, to.std_x, to.std_rate})
          if (value) value[k] = std::numeric_limits<double>::quiet_NaN();
      }
    }
    if (k > 0) {
      move(k);
      retreat<WITH_COVARIANCE>(step, left.noise, at);
    }
  };
  forward_and_back(n, Information<N>(), forward, [](const Information<N>&) {}, back);
}

// The same with all that a SmoothedColumn has room for, or with values and rates alone.
ORBIDENT_WIDEST inline void smooth_side_by_side(const double* t, std::ptrdiff_t n,
                                                const SampledColumn* columns,
                                                const SmoothedColumn* out) {
  smooth_lanes<true>(t, n, columns, out);
}
ORBIDENT_WIDEST inline void rates_side_by_side(const double* t, std::ptrdiff_t n,
                                               const SampledColumn* columns,
                                               const SmoothedColumn* out) {
  smooth_lanes<false>(t, n, columns, out);
}

}  // namespace orbident
