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
      BodiesMemory<double> memory(tree);
      Bodies<double>& at = memory.at;
      std::vector<double> room(static_cast<std::size_t>(3 * (3 * m + phis)));
      const Rows3<double> S(room.data(), 3, m), P(room.data() + 3 * m, 3, m),
          A(room.data() + 6 * m, 3, m), S_sigma(room.data() + 9 * m, 3, phis);
      const NoHeap guard;
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
      std::vector<T> room(static_cast<std::size_t>(3 * (3 * m + pis + 2 * phis) + 2 * K));
      T* next = room.data();
      const auto rows = [&next](std::ptrdiff_t columns) {
        T* data = next;
        next += 3 * columns;
        return Rows3<T>(data, 3, columns);
      };
      const Rows3<T> S = rows(m), P = rows(m), A = rows(m);
      Rows3<T> Y = rows(pis), W = rows(phis), S_sigma = rows(phis);
      T *q_k = next, *qd_k = next + K;
      const NoHeap guard;
      for (std::ptrdiff_t k = first; k < last; ++k) {
        for (std::ptrdiff_t j = 0; j < K; ++j) {
          q_k[j] = {q.data()[k * K + j], T::Derivatives(qd.data()[k * K + j])};
          qd_k[j] = {qd.data()[k * K + j], T::Derivatives(qdd.data()[k * K + j])};
        }
        place(tree, q_k, at.pose, at.field);
        const Vector3<double> w_k(w.data() + 3 * k);
        move(tree, at.field, Vector3<T>(w_k[0], w_k[1], w_k[2]), qd_k, at.motion);
        first_moment_columns(tree, at.pose, S);
        momentum_columns(tree, at.pose, at.motion, P, A);
        regressors(sets, S, P, A, S_sigma, Y, W);
        for (int i = 0; i < 3; ++i) {
          double sum = 0.0;
          for (std::ptrdiff_t j = 0; j < pis; ++j) sum += Y(i, j).v[0] * pi.data()[j];
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
      .def("__init__", [](OwnedMinimalSets* self, const OwnedTree& tree, const Array& linear,
                          const Array& sigma, const Array& pairs) {
        new (self) OwnedMinimalSets(make_sets(tree, linear, sigma, pairs));
      }, nb::arg("tree"), nb::arg("theta_of_linear"), nb::arg("theta_of_sigma"),
           nb::arg("pairs"));
  m.def("regressors", &regressors_of, nb::arg("sets"), nb::arg("q"), nb::arg("qd"), nb::arg("w"),
        nb::arg("threads") = 1, "Y (Eq. 19) and W (Eq. 29), all three axes, base axes.");
  m.def("momentum_rate", &momentum_rate, nb::arg("sets"), nb::arg("q"), nb::arg("qd"),
        nb::arg("qdd"), nb::arg("w"), nb::arg("pi"), nb::arg("threads") = 1,
        "d/dt (Y pi) by the joints alone, the base rate held; base axes.");
}

}  // namespace orbident::python
