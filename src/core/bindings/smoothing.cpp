// Smoothing of many columns.
#include "orbident/smoothing.hpp"

#include <nanobind/stl/tuple.h>

#include <algorithm>

#include "arrays.hpp"
#include "orbident/parallel.hpp"
#include "orbident/smoothing_evidence.hpp"

namespace orbident::python {
namespace {

// Columns of samples at common times, and how each of them is to be smoothed.
struct Columns {
  In<1> t;
  In<2> x;
  In<1> density, h, noise_std, offset;
  std::ptrdiff_t rows() const { return t.size(0); }
  std::ptrdiff_t count() const { return x.size(1); }
};

Columns columns_of(const Array& t_, const Array& x_, const Array& density, const Array& h,
                   const Array& noise_std, const Array& offset) {
  const auto t = input<1>("t", t_, {ANY});
  const auto x = input<2>("x", x_, {t.size(0), ANY});
  const std::ptrdiff_t columns = x.size(1);
  return {t,
          x,
          input<1>("density", density, {columns}),
          input<1>("h", h, {columns}),
          input<1>("noise_std", noise_std, {columns}),
          input<1>("offset", offset, {columns})};
}

// SIDE_BY_SIDE columns at once; place(c) is where the results of column c go.
template <class Smooth, class Place>
void smooth_all(const Columns& columns, int threads, const Smooth& smooth, const Place& place) {
  nb::gil_scoped_release release;
  const std::ptrdiff_t count = columns.count();
  const auto smooth_group = [&](std::ptrdiff_t group) {
    SampledColumn from[SIDE_BY_SIDE];
    SmoothedColumn to[SIDE_BY_SIDE];
    for (int l = 0; l < SIDE_BY_SIDE; ++l) {
      // Lanes that are left over have the last column again.
      const std::ptrdiff_t c = std::min(group * SIDE_BY_SIDE + l, count - 1);
      from[l] = {columns.x.data() + c,     count,
                 columns.h.data()[c],      columns.noise_std.data()[c],
                 columns.offset.data()[c], columns.density.data()[c]};
      to[l] = place(c);
    }
    smooth(columns.t.data(), columns.rows(), from, to);
  };
  const std::ptrdiff_t groups = (count + SIDE_BY_SIDE - 1) / SIDE_BY_SIDE;
  parallel_for(groups, threads, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
    for (std::ptrdiff_t k = from; k < to; ++k) smooth_group(k);
  }, 1);
}

auto smooth_columns(const Array& t, const Array& x, const Array& density, const Array& h,
                    const Array& noise_std, const Array& offset, int threads) {
  const Columns columns = columns_of(t, x, density, h, noise_std, offset);
  const std::ptrdiff_t n = columns.rows(), count = columns.count();
  Out<2> value(count, n), rate(count, n), acceleration(count, n), std_x(count, n),
      std_rate(count, n);
  smooth_all(columns, threads, smooth_side_by_side, [&](std::ptrdiff_t c) -> SmoothedColumn {
    return {value.data() + c * n, rate.data() + c * n, acceleration.data() + c * n,
            std_x.data() + c * n, std_rate.data() + c * n};
  });
  return std::make_tuple(value.give(), rate.give(), acceleration.give(), std_x.give(),
                         std_rate.give());
}

auto smooth_rates(const Array& t, const Array& x, const Array& density, const Array& h,
                  const Array& noise_std, const Array& offset, int threads) {
  const Columns columns = columns_of(t, x, density, h, noise_std, offset);
  const std::ptrdiff_t n = columns.rows(), count = columns.count();
  Out<2> value(count, n), rate(count, n);
  smooth_all(columns, threads, rates_side_by_side, [&](std::ptrdiff_t c) -> SmoothedColumn {
    return {value.data() + c * n, rate.data() + c * n, nullptr, nullptr, nullptr};
  });
  return std::make_tuple(value.give(), rate.give());
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
      const std::ptrdiff_t first = group * DENSITIES,
                           count = std::min<std::ptrdiff_t>(DENSITIES, tried - first);
      // Lanes that are left over have the last one again.
      double densities[DENSITIES];
      for (std::ptrdiff_t l = 0; l < DENSITIES; ++l)
        densities[l] = density.data()[first + std::min(l, count - 1)];
      Evidence found;
      evidence_of(t.data() + stretch * n, x.data() + stretch * n, n, densities, found);
      std::copy_n(found.misfit, count, misfit.data() + stretch * tried + first);
      std::copy_n(found.log_det, count, log_det.data() + stretch * tried + first);
    };
    parallel_for(stretches * groups, threads, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
      for (std::ptrdiff_t k = from; k < to; ++k) weigh(k / groups, k % groups);
    }, 1);
  }
  return std::make_tuple(misfit.give(), log_det.give());
}

}  // namespace

void bind_smoothing(nb::module_& m) {
  m.def("smooth_columns", &smooth_columns, nb::arg("t"), nb::arg("x"), nb::arg("density"),
        nb::arg("h"), nb::arg("noise_std"), nb::arg("offset"), nb::arg("threads") = 1,
        "Value, rate, acceleration, std of value and of rate, each columns by rows.");
  m.def("smooth_rates", &smooth_rates, nb::arg("t"), nb::arg("x"), nb::arg("density"), nb::arg("h"),
        nb::arg("noise_std"), nb::arg("offset"), nb::arg("threads") = 1,
        "Value and rate alone, each columns by rows.");
  m.def("smoothing_evidence", &smoothing_evidence, nb::arg("t"), nb::arg("x"), nb::arg("density"),
        nb::arg("threads") = 1, "Misfit and log determinant, stretches by densities.");
}

}  // namespace orbident::python
