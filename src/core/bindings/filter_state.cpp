// What the recursive filter carries, as arrays.
#include "arrays.hpp"
#include "filter.hpp"

namespace orbident::python {
namespace {

auto vector(const double* from, int size) {
  Out<1> out(size);
  std::copy(from, from + size, out.data());
  return out.give();
}

// A table whose rows lie `stride` entries apart in the state.
auto table(const double* from, int rows, int columns, int stride) {
  Out<2> out(rows, columns);
  for (int i = 0; i < rows; ++i)
    std::copy(from + static_cast<std::ptrdiff_t>(i) * stride,
              from + static_cast<std::ptrdiff_t>(i) * stride + columns,
              out.data() + static_cast<std::ptrdiff_t>(i) * columns);
  return out.give();
}

// [iota, M, sigma | z] in the order of beta.
auto information(const FilterSizes& size, const double* from, bool with_z) {
  const int k = size.betas(), columns = with_z ? k + 1 : k;
  Out<2> out(k, columns);
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < columns; ++j) {
      const int own = j == k ? k : j < size.shown ? size.iotas + j : j - size.shown;
      out.data()[i * columns + j] = from[i * size.beta_stride() + own];
    }
  return out.give();
}

auto numbers_of(const OwnedState& s) {
  return vector(s.numbers().data(), static_cast<int>(s.numbers().size()));
}
auto beta_of(const OwnedState& s) { return vector(s.at.beta, s.size.betas()); }
auto nuisances_of(const OwnedState& s) { return vector(s.at.x, s.size.nuisances); }
auto R_WB_of(const OwnedState& s) { return table(s.at.R_WB, 3, 3, 3); }
auto top_of(const OwnedState& s) {
  const int n = s.size.nuisances, iotas = s.size.iotas, shown = s.size.shown;
  const bool reduced = held_in_beta(s.at);
  const int columns = n + (reduced ? s.size.betas() : s.size.parameters) + 1;
  Out<2> out(n, columns);
  for (int i = 0; i < n; ++i) {
    const double* const from = s.at.top + i * s.size.top_stride();
    double* const row = out.data() + i * columns;
    std::copy(from, from + columns, row);
    // [iota, M, sigma] in the order of beta.
    if (reduced) std::rotate(row + n, row + n + iotas, row + n + iotas + shown);
  }
  return out.give();
}
auto R_z_of(const OwnedState& s) {
  return table(s.at.R, s.size.parameters, s.size.parameters + 1, s.size.R_stride());
}
auto root_of(const OwnedState& s) { return information(s.size, s.at.root, false); }
auto prior_of(const OwnedState& s) { return information(s.size, s.at.prior, true); }

}  // namespace

void bind_filter_state(nb::module_& m) {
  nb::class_<OwnedState>(m, "FilterState", "What the recursive filter carries; a constant.")
      .def_prop_ro("numbers", &numbers_of, nb::rv_policy::move)
      .def_prop_ro("t", [](const OwnedState& s) { return *s.at.t; })
      .def_prop_ro("held_in_beta", [](const OwnedState& s) { return held_in_beta(s.at); })
      .def_prop_ro("beta", &beta_of, nb::rv_policy::move)
      .def_prop_ro("nuisances", &nuisances_of, nb::rv_policy::move)
      .def_prop_ro("R_WB", &R_WB_of, nb::rv_policy::move)
      .def_prop_ro("top", &top_of, nb::rv_policy::move)
      .def_prop_ro("R_z", &R_z_of, nb::rv_policy::move)
      .def_prop_ro("root", &root_of, nb::rv_policy::move)
      .def_prop_ro("prior", &prior_of, nb::rv_policy::move);
}

}  // namespace orbident::python
