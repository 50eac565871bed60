// The attitude at many rows from a gyro, and what its fixes say of the gyro's error.
#include "orbident/attitude_fusion.hpp"

#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "orbident/forward_and_back.hpp"

namespace orbident::python {
namespace {

Vector3<double> vector3(const double* v) { return {v[0], v[1], v[2]}; }

auto integrate_rate(const Array& x_start_, const Array& h_, const Array& w_1_, const Array& w_2_) {
  const auto x_start = input<1>("x_start", x_start_, {4});
  const auto h = input<1>("h", h_, {ANY});
  const std::ptrdiff_t n = h.size(0);
  const auto w_1 = input<2>("w_1", w_1_, {n, 3});
  const auto w_2 = input<2>("w_2", w_2_, {n, 3});
  Out<2> x_WB(n + 1, 4);
  {
    nb::gil_scoped_release release;
    Eigen::Map<Eigen::Matrix<double, 4, Eigen::Dynamic>> rows(x_WB.data(), 4, n + 1);
    Quaternion<double> x(x_start.data());
    rows.col(0) = x;
    for (std::ptrdiff_t k = 0; k < n; ++k) {
      x = turned(x, magnus_rotation(h.data()[k], vector3(w_1.data() + 3 * k),
                                    vector3(w_2.data() + 3 * k)));
      rows.col(k + 1) = x;
    }
  }
  return x_WB.give();
}

auto smooth_gyro_error(const Array& B_, const Array& h_, const Array& y_, const Array& noise_,
                       const Array& before_) {
  const auto y = input<2>("y", y_, {ANY, 3});
  const std::ptrdiff_t n = y.size(0);
  if (n < 1) throw nb::value_error("y has no rows; give at least one");
  const auto B = input<3>("B", B_, {n - 1, 3, 3});
  const auto h = input<1>("h", h_, {n - 1});
  const auto noise = input<1>("noise", noise_, {3});
  const auto before = input<1>("before", before_, {2});
  const double N = noise.data()[0], drift = noise.data()[1], std = noise.data()[2];
  Out<2> mean(n, 6), variance(n, 6);
  {
    nb::gil_scoped_release release;
    // From row k - 1 to row k.
    const auto step = [&](std::ptrdiff_t k) {
      using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
      const double dt = h.data()[k - 1];
      return GyroStep<double>{Eigen::Map<const Rows>(B.data() + 9 * (k - 1)), N * N * dt,
                              drift * drift * dt};
    };
    const auto forward = [&](std::ptrdiff_t k, GyroError<double>& known) {
      if (k > 0) known = predicted(step(k), known);
      const Vector3<double> fix = vector3(y.data() + 3 * k);
      if (!fix.hasNaN()) correct(fix, std * std, known);
      return known;
    };
    GyroError<double> at;
    const auto turn = [&](const GyroError<double>& last) { at = last; };
    const auto back = [&](std::ptrdiff_t k, const GyroError<double>& filtered) {
      if (k < n - 1) at = smoothed(filtered, step(k + 1), at);
      Eigen::Map<Vector6<double>>(mean.data() + 6 * k) = at.mean;
      Eigen::Map<Vector6<double>>(variance.data() + 6 * k) = at.covariance.diagonal();
    };
    GyroError<double> start{Vector6<double>::Zero(), Matrix6<double>::Zero()};
    start.covariance.diagonal() << Vector3<double>::Constant(before.data()[0] * before.data()[0]),
        Vector3<double>::Constant(before.data()[1] * before.data()[1]);
    forward_and_back(n, start, forward, turn, back);
  }
  return std::make_tuple(mean.give(), variance.give());
}

}  // namespace

void bind_attitude_fusion(nb::module_& m) {
  m.def("integrate_rate", &integrate_rate, nb::arg("x_start"), nb::arg("h"), nb::arg("w_1"),
        nb::arg("w_2"), "The attitude before, between and after steps, by Magnus.");
  m.def("smooth_gyro_error", &smooth_gyro_error, nb::arg("B"), nb::arg("h"), nb::arg("y"),
        nb::arg("noise"), nb::arg("before"),
        "Mean and variance of [phi, b] at each row. `noise`: angle random walk, drift of the bias, "
        "std of a fix; `before`: std of phi and of b beforehand.");
}

}  // namespace orbident::python
