// Y and W of many samples.
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

OwnedMinimalSets make_sets(const OwnedTree& tree, const Array& linear, const Array& sigma,
                           const Array& pairs_) {
  const std::int64_t m = PER_BODY * tree.view().bodies();
  const auto theta_of_linear = input<2>("theta_of_linear", linear, {m, ANY});
  const auto theta_of_sigma = input<2>("theta_of_sigma", sigma, {m, ANY});
  const auto pairs = input<2>("pairs", pairs_, {ANY, 2});
  OwnedMinimalSets sets{tree, sparse(theta_of_linear), sparse(theta_of_sigma), {}};
  for (std::ptrdiff_t k = 0; k < 2 * pairs.size(0); ++k) {
    const double index = pairs.data()[k];
    if (!(index >= 0 && index < static_cast<double>(theta_of_sigma.size(1))))
      throw nb::value_error("pairs: an index is not one of sigma");
    sets.pairs.push_back(static_cast<int>(index));
  }
  return sets;
}

auto regressors_of(const OwnedMinimalSets& owned, const Array& q_, const Array& qd_,
                   const Array& w_, int threads) {
  const Tree tree = owned.tree.view();
  const MinimalSets sets = owned.view();
  const auto q = input<2>("q", q_, {ANY, tree.joints});
  const std::ptrdiff_t n = q.size(0), m = PER_BODY * tree.bodies();
  const auto qd = input<2>("qd", qd_, {n, tree.joints});
  const auto w = input<2>("w", w_, {n, 3});
  const std::ptrdiff_t pis = sets.pis(), phis = sets.phis();
  Out<3> Y(n, 3, pis), W(n, 3, phis);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      BodiesMemory<double> memory(tree);
      Bodies<double>& at = memory.at;
      std::vector<double> room(static_cast<std::size_t>(3 * (3 * m + phis)));
      const Rows3<double> S(room.data(), 3, m), P(room.data() + 3 * m, 3, m),
          A(room.data() + 6 * m, 3, m), S_sigma(room.data() + 9 * m, 3, phis);
      for (std::ptrdiff_t k = first; k < last; ++k) {
        place(tree, q.data() + k * tree.joints, at.pose, at.field);
        move(tree, at.field, Vector3<double>(w.data() + 3 * k), qd.data() + k * tree.joints,
             at.motion);
        first_moment_columns(tree, at.pose, S);
        momentum_columns(tree, at.pose, at.motion, P, A);
        regressors(sets, S, P, A, S_sigma, Rows3<double>(Y.data() + 3 * pis * k, 3, pis),
                   Rows3<double>(W.data() + 3 * phis * k, 3, phis));
      }
    });
  }
  return std::make_tuple(Y.give(), W.give());
}

}  // namespace

void bind_regressors(nb::module_& m) {
  nb::class_<OwnedMinimalSets>(m, "MinimalSets", "What Y and W need of a robot.")
      .def("__init__", [](OwnedMinimalSets* self, const OwnedTree& tree, const Array& linear,
                          const Array& sigma, const Array& pairs) {
        new (self) OwnedMinimalSets(make_sets(tree, linear, sigma, pairs));
      }, nb::arg("tree"), nb::arg("theta_of_linear"), nb::arg("theta_of_sigma"),
           nb::arg("pairs"));
  m.def("regressors", &regressors_of, nb::arg("sets"), nb::arg("q"), nb::arg("qd"), nb::arg("w"),
        nb::arg("threads") = 1, "Y (Eq. 19) and W (Eq. 29), all three axes, base axes.");
}

}  // namespace orbident::python
