// Whole columns through white_snap.hpp: what they most likely were.
#pragma once

#include "orbident/forward_and_back.hpp"
#include "orbident/white_snap.hpp"

namespace orbident {

// The samples of one column: NaN on a row without one.
template <class T>
struct SampledColumn {
  const double* t;
  const double* x;
  std::ptrdiff_t rows;
  // Between two rows of x, whose columns lie side by side.
  std::ptrdiff_t stride;
  // Units of time (s) and noise, and what is taken off the samples.
  T h, noise_std, offset;
  // Spectral density of the snap in these units.
  T density;

  // From row k - 1 to row k.
  white_snap::Motion<T> motion(std::ptrdiff_t k) const {
    return white_snap::motion(T((t[k] - t[k - 1]) / h), density);
  }
  bool sampled(std::ptrdiff_t k) const { return !std::isnan(x[k * stride]); }
  T y(std::ptrdiff_t k) const { return T(x[k * stride]) - offset; }
};

// One value a row of the column.
template <class T>
struct SmoothedColumn {
  T* x;
  T* rate;
  T* acceleration;
  T* std_x;
  T* std_rate;
};

template <class T>
void write(const SampledColumn<T>& column, const white_snap::Estimate<T>& at, std::ptrdiff_t k,
           const SmoothedColumn<T>& out) {
  using std::sqrt;
  out.x[k] = at.mean[0] + column.offset;
  out.rate[k] = at.mean[1] / column.h;
  out.acceleration[k] = at.mean[2] / (column.h * column.h);
  out.std_x[k] = column.noise_std * sqrt(at.covariance(0, 0));
  out.std_rate[k] = column.noise_std * sqrt(at.covariance(1, 1)) / column.h;
}

// The smoothing spline at the rows `first` to `last`, both with a sample.
template <class T>
void smooth_column(const SampledColumn<T>& column, std::ptrdiff_t first, std::ptrdiff_t last,
                   const SmoothedColumn<T>& out) {
  using namespace white_snap;
  const auto forward = [&](std::ptrdiff_t step, Information<T>& known) {
    const std::ptrdiff_t k = first + step;
    const SnapRows<T> noise = k > first ? advance(column.motion(k), known) : SnapRows<T>::Zero();
    if (column.sampled(k)) measure(column.y(k), known);
    return noise;
  };
  Estimate<T> at;
  const auto turn = [&](const Information<T>& known) { at = final_estimate(known); };
  const auto back = [&](std::ptrdiff_t step, const SnapRows<T>& noise) {
    const std::ptrdiff_t k = first + step;
    write(column, at, k, out);
    if (k > first) retreat(column.motion(k), noise, at);
  };
  forward_and_back(last - first + 1, Information<T>(), forward, turn, back);
}

}  // namespace orbident
