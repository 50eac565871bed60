// Folding rows into a triangular factor.
#include <algorithm>
#include <vector>

#include "arrays.hpp"
#include "orbident/householder.hpp"

namespace orbident::python {
namespace {

auto folded(const Array& R_, const Array& rows_) {
  const auto R = input<2>("R", R_, {ANY, ANY});
  const std::ptrdiff_t n = R.size(0);
  if (R.size(1) != n) throw nb::value_error("R is not square");
  const auto rows = input<2>("rows", rows_, {ANY, n});
  const int columns = static_cast<int>(n), m = static_cast<int>(rows.size(0));
  Out<2> factor(n, n);
  {
    nb::gil_scoped_release release;
    std::copy_n(R.data(), n * n, factor.data());
    // What stands below the diagonal is no part of R.
    for (std::ptrdiff_t i = 0; i < n; ++i) std::fill_n(factor.data() + i * n, i, 0.0);
    std::vector<double> X(rows.data(), rows.data() + rows.size(0) * n);
    fold(factor.data(), n, X.data(), n, m, columns, columns);
  }
  return factor.give();
}

}  // namespace

void bind_householder(nb::module_& m) {
  m.def("fold", &folded, nb::arg("R"), nb::arg("rows"),
        "The triangular factor R with some more rows.");
}

}  // namespace orbident::python
