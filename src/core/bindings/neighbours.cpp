// What neighbours expect of every sample of a column.
#include "orbident/neighbours.hpp"

#include "arrays.hpp"
#include "orbident/parallel.hpp"

namespace orbident::python {
namespace {

auto expected_samples(const Array& t_, const Array& x_, int farthest, int threads) {
  const auto t = input<1>("t", t_, {ANY});
  const std::ptrdiff_t n = t.size(0);
  const auto x = input<1>("x", x_, {n});
  Out<1> out(n);
  {
    nb::gil_scoped_release release;
    const int count = distances(n, farthest);
    if (count < 1)
      std::copy_n(x.data(), n, out.data());
    else
      parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
        for (std::ptrdiff_t k = first; k < last; ++k)
          out.data()[k] = expected(t.data(), x.data(), n, k, count);
      }, 2048);
  }
  return out.give();
}

}  // namespace

void bind_neighbours(nb::module_& m) {
  m.def("expected_samples", &expected_samples, nb::arg("t"), nb::arg("x"), nb::arg("farthest"),
        nb::arg("threads"),
        "The median of what cubics through neighbours at several distances predict.");
}

}  // namespace orbident::python
