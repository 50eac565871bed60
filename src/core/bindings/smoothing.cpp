// Smoothing of many columns.
#include "orbident/smoothing.hpp"

#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <limits>

#include "arrays.hpp"
#include "orbident/parallel.hpp"
#include "orbident/smoothing_evidence.hpp"

namespace orbident::python {
namespace {

auto smooth_columns(const Array& t_, const Array& x_, const Array& density_, const Array& h_,
                    const Array& noise_std_, const Array& offset_, int threads) {
  const auto t = input<1>("t", t_, {ANY});
  const std::ptrdiff_t n = t.size(0);
  const auto x = input<2>("x", x_, {n, ANY});
  const std::ptrdiff_t columns = x.size(1);
  const auto density = input<1>("density", density_, {columns});
  const auto h = input<1>("h", h_, {columns});
  const auto noise_std = input<1>("noise_std", noise_std_, {columns});
  const auto offset = input<1>("offset", offset_, {columns});
  Out<2> value(columns, n), rate(columns, n), acceleration(columns, n), std_x(columns, n),
      std_rate(columns, n);
  {
    nb::gil_scoped_release release;
    const auto smooth = [&](std::ptrdiff_t c) {
      const SampledColumn column{t.data(),           x.data() + c,     columns,          h.data()[c],
                                 noise_std.data()[c], offset.data()[c], density.data()[c]};
      std::ptrdiff_t first = 0, last = n - 1;
      while (first < n && !column.sampled(first)) ++first;
      while (last > first && !column.sampled(last)) --last;
      for (Out<2>* out : {&value, &rate, &acceleration, &std_x, &std_rate}) {
        double* const row = out->data() + c * n;
        std::fill(row, row + first, std::numeric_limits<double>::quiet_NaN());
        std::fill(row + std::min(last + 1, n), row + n, std::numeric_limits<double>::quiet_NaN());
      }
      if (first < n)
        smooth_column(column, first, last,
                      SmoothedColumn{value.data() + c * n, rate.data() + c * n,
                                             acceleration.data() + c * n, std_x.data() + c * n,
                                             std_rate.data() + c * n});
    };
    parallel_for(
        columns, threads,
        [&](std::ptrdiff_t from, std::ptrdiff_t to) {
          for (std::ptrdiff_t c = from; c < to; ++c) smooth(c);
        },
        1);
  }
  return std::make_tuple(value.give(), rate.give(), acceleration.give(), std_x.give(),
                         std_rate.give());
}

auto smoothing_evidence(const Array& t_, const Array& x_, const Array& density_, int threads) {
  const auto t = input<2>("t", t_, {ANY, ANY});
  const std::ptrdiff_t stretches = t.size(0), n = t.size(1);
  if (n < 1) throw nb::value_error("t has no rows; give at least one");
  const auto x = input<2>("x", x_, {stretches, n});
  const auto density = input<1>("density", density_, {ANY});
  const std::ptrdiff_t tried = density.size(0);
  Out<2> misfit(stretches, tried), log_det(stretches, tried);
  {
    nb::gil_scoped_release release;
    const std::ptrdiff_t groups = (tried + DENSITIES - 1) / DENSITIES;
    const auto weigh = [&](std::ptrdiff_t stretch, std::ptrdiff_t group) {
      const std::ptrdiff_t first = group * DENSITIES, count = std::min<std::ptrdiff_t>(DENSITIES, tried - first);
      // Lanes that are left over have the last one again.
      double densities[DENSITIES];
      for (std::ptrdiff_t l = 0; l < DENSITIES; ++l)
        densities[l] = density.data()[first + std::min(l, count - 1)];
      Evidence found;
      evidence_of(t.data() + stretch * n, x.data() + stretch * n, n, densities, found);
      std::copy_n(found.misfit, count, misfit.data() + stretch * tried + first);
      std::copy_n(found.log_det, count, log_det.data() + stretch * tried + first);
    };
    parallel_for(
        stretches * groups, threads,
        [&](std::ptrdiff_t from, std::ptrdiff_t to) {
          for (std::ptrdiff_t k = from; k < to; ++k) weigh(k / groups, k % groups);
        },
        1);
  }
  return std::make_tuple(misfit.give(), log_det.give());
}

}  // namespace

void bind_smoothing(nb::module_& m) {
  m.def("smooth_columns", &smooth_columns, nb::arg("t"), nb::arg("x"), nb::arg("density"),
        nb::arg("h"), nb::arg("noise_std"), nb::arg("offset"), nb::arg("threads") = 1,
        "Value, rate, acceleration, std of value and of rate, each columns by rows.");
  m.def("smoothing_evidence", &smoothing_evidence, nb::arg("t"), nb::arg("x"), nb::arg("density"),
        nb::arg("threads") = 1, "Misfit and log determinant, stretches by densities.");
}

}  // namespace orbident::python
