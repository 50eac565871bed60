// Whole columns through white_snap.hpp: what they most likely were.
#pragma once

#include "orbident/forward_and_back.hpp"
#include "orbident/white_snap.hpp"

namespace orbident {

// The samples of one column: NaN on a row without one.
struct SampledColumn {
  const double* t;
  const double* x;
  // Between two rows of x, whose columns lie side by side.
  std::ptrdiff_t stride;
  // Units of time (s) and noise, and what is taken off the samples.
  double h, noise_std, offset;
  // Spectral density of the snap in these units.
  double density;

  // From row k - 1 to row k.
  white_snap::Motion motion(std::ptrdiff_t k) const {
    return white_snap::motion((t[k] - t[k - 1]) / h, density);
  }
  bool sampled(std::ptrdiff_t k) const { return !std::isnan(x[k * stride]); }
  double y(std::ptrdiff_t k) const { return x[k * stride] - offset; }
};

// One value a row of the column.
struct SmoothedColumn {
  double* x;
  double* rate;
  double* acceleration;
  double* std_x;
  double* std_rate;
};

inline void write(const SampledColumn& column, const white_snap::Estimate& at, std::ptrdiff_t k,
                  const SmoothedColumn& out) {
  out.x[k] = at.mean[0] + column.offset;
  out.rate[k] = at.mean[1] / column.h;
  out.acceleration[k] = at.mean[2] / (column.h * column.h);
  out.std_x[k] = column.noise_std * std::sqrt(at.covariance(0, 0));
  out.std_rate[k] = column.noise_std * std::sqrt(at.covariance(1, 1)) / column.h;
}

// The smoothing spline at the rows `first` to `last`, both with a sample.
inline void smooth_column(const SampledColumn& column, std::ptrdiff_t first, std::ptrdiff_t last,
                          const SmoothedColumn& out) {
  using namespace white_snap;
  const auto forward = [&](std::ptrdiff_t step, Information<1>& known) {
    const std::ptrdiff_t k = first + step;
    Triangle<1> noise = {};
    double left[1];
    if (k > first) advance(column.motion(k), {1.0}, known, noise);
    if (column.sampled(k)) measure(column.y(k), known, left);
    return SnapRows(Eigen::Map<const SnapRows>(noise[0][0]));
  };
  Estimate at;
  const auto turn = [&](const Information<1>& known) { at = final_estimate(known); };
  const auto back = [&](std::ptrdiff_t step, const SnapRows& noise) {
    const std::ptrdiff_t k = first + step;
    write(column, at, k, out);
    if (k > first) retreat(column.motion(k), noise, at);
  };
  forward_and_back(last - first + 1, Information<1>(), forward, turn, back);
}

}  // namespace orbident
