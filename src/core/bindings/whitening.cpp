// The innovations of one axis of a sensor.
#include "orbident/whitening.hpp"

#include <nanobind/stl/tuple.h>

#include <vector>

#include "arrays.hpp"

namespace orbident::python {
namespace {

auto innovations(const Array& t_, const Array& rows_, const Array& variance_,
                 const Array& coloured) {
  const auto t = input<1>("t", t_, {ANY});
  const std::ptrdiff_t n = t.size(0);
  const auto rows = input<2>("rows", rows_, {n, ANY});
  const auto variance = input<1>("variance", variance_, {n});
  const auto given = input<1>("coloured", coloured, {4});
  const std::ptrdiff_t width = rows.size(1);
  Out<2> innovated(n, width);
  Out<1> S(n);
  {
    nb::gil_scoped_release release;
    std::vector<double> mean(static_cast<std::size_t>(Coloured::PARTS * width));
    Whitening filter{};
    filter.width = static_cast<int>(width);
    for (int part = 0; part < Coloured::PARTS; ++part)
      filter.mean[part] = mean.data() + part * width;
    const Coloured noise{given.data()[0], given.data()[1], given.data()[2], given.data()[3]};
    if (n > 0) filter.start_stationary(noise, t.data()[0]);
    std::copy_n(rows.data(), n * width, innovated.data());
    for (std::ptrdiff_t k = 0; k < n; ++k) {
      filter.predict(t.data()[k]);
      S.data()[k] = filter.innovate(innovated.data() + k * width, variance.data()[k]);
    }
  }
  return std::make_tuple(innovated.give(), S.give());
}

}  // namespace

void bind_whitening(nb::module_& m) {
  m.def("innovations", &innovations, nb::arg("t"), nb::arg("rows"), nb::arg("variance"),
        nb::arg("coloured"),
        "The innovations of rows and their variances; `coloured`: std and time of a Gauss-Markov "
        "process, densities of a random walk and of a rate that walks.");
}

}  // namespace orbident::python
