// Y and W of many samples.
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "orbident/jet.hpp"
#include "orbident/no_heap.hpp"
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
      MovingBodies bodies(tree, q, qd, w);
      OwnedRows<Lanes> S(m), P(m), A(m), S_sigma(phis), Y_k(pis), W_k(phis);
      const NoHeap guard;
      by_groups(first, last, [&](const Group& group) {
        const Bodies<Lanes>& at = bodies.at(group);
        first_moment_columns(tree, at.pose, S.view);
        momentum_columns(tree, at.pose, at.motion, P.view, A.view);
        regressors(sets, S.view, P.view, A.view, S_sigma.view, Y_k.view, W_k.view);
        Y.store(group, Y_k.numbers.data());
        W.store(group, W_k.numbers.data());
      });
    });
  }
  return std::make_tuple(Y.give(), W.give());
}

// d/dt (Y pi) by the joints alone, the base rate held: Y of jets whose derivative is the time's.
auto momentum_rate(const OwnedMinimalSets& owned, const Array& q_, const Array& qd_,
                   const Array& qdd_, const Array& w_, const Array& pi_, int threads) {
  using T = Jet<1>;
  const Tree tree = owned.tree.view();
  const MinimalSets sets = owned.view();
  const std::ptrdiff_t K = tree.joints, m = PER_BODY * tree.bodies();
  const std::ptrdiff_t pis = sets.pis(), phis = sets.phis();
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t n = q.size(0);
  const auto qd = input<2>("qd", qd_, {n, K});
  const auto qdd = input<2>("qdd", qdd_, {n, K});
  const auto w = input<2>("w", w_, {n, 3});
  const auto pi = input<1>("pi", pi_, {pis});
  Out<2> rate(n, 3);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      BodiesMemory<T> memory(tree);
      Bodies<T>& at = memory.at;
      OwnedRows<T> S(m), P(m), A(m), S_sigma(phis), Y(pis), W(phis);
      std::vector<T> q_k = room<T>(K), qd_k = room<T>(K);
      const NoHeap guard;
      for (std::ptrdiff_t k = first; k < last; ++k) {
        for (std::ptrdiff_t j = 0; j < K; ++j) {
          const std::ptrdiff_t i = k * K + j;
          q_k[static_cast<std::size_t>(j)] = {q.data()[i], T::Derivatives(qd.data()[i])};
          qd_k[static_cast<std::size_t>(j)] = {qd.data()[i], T::Derivatives(qdd.data()[i])};
        }
        place(tree, q_k.data(), at.pose, at.field);
        const Vector3<double> w_k(w.data() + 3 * k);
        move(tree, at.field, Vector3<T>(w_k[0], w_k[1], w_k[2]), qd_k.data(), at.motion);
        first_moment_columns(tree, at.pose, S.view);
        momentum_columns(tree, at.pose, at.motion, P.view, A.view);
        regressors(sets, S.view, P.view, A.view, S_sigma.view, Y.view, W.view);
        for (int i = 0; i < 3; ++i) {
          double sum = 0.0;
          for (std::ptrdiff_t j = 0; j < pis; ++j) sum += Y.view(i, j).v[0] * pi.data()[j];
          rate.data()[3 * k + i] = sum;
        }
      }
    });
  }
  return rate.give();
}

}  // namespace

void bind_regressors(nb::module_& m) {
  nb::class_<OwnedMinimalSets>(m, "MinimalSets", "What Y and W need of a robot.")
      .def(nb::new_(&make_sets), nb::arg("tree"), nb::arg("theta_of_linear"),
           nb::arg("theta_of_sigma"), nb::arg("pairs"));
  m.def("regressors", &regressors_of, nb::arg("sets"), nb::arg("q"), nb::arg("qd"), nb::arg("w"),
        nb::arg("threads") = 1, "Y (Eq. 19) and W (Eq. 29), all three axes, base axes.");
  m.def("momentum_rate", &momentum_rate, nb::arg("sets"), nb::arg("q"), nb::arg("qd"),
        nb::arg("qdd"), nb::arg("w"), nb::arg("pi"), nb::arg("threads") = 1,
        "d/dt (Y pi) by the joints alone, the base rate held; base axes.");
}

}  // namespace orbident::python
