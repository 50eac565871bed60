// Free floating over many joint states, and the attitude along them.
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <cmath>

#include "arrays.hpp"
#include "orbident/free_floating.hpp"
#include "orbident/no_heap.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

template <class T>
using RowMajor3 = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;

// Group by group: the terms at many joint states.
template <class Use>
void each_group(const Robot& robot, const In<2>& q, const In<2>& qd, int threads, Use&& use) {
  const std::ptrdiff_t K = robot.tree.joints;
  parallel_for(q.size(0), threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    BodiesMemory<Lanes> memory(robot.tree);
    const Bodies<Lanes>& at = memory.at;
    std::vector<Lanes> q_k = room<Lanes>(K), qd_k = room<Lanes>(K);
    const NoHeap guard;
    by_groups(first, last, [&](const Group& group) {
      q.load(group, q_k.data());
      qd.load(group, qd_k.data());
      use(group, floating_terms(robot.tree, robot.theta, q_k.data(), qd_k.data(), at.pose, at.field,
                                at.motion, at.mass));
    });
  });
}

// E and b at many times.
struct Laws {
  Out<3> E;
  Out<2> b;
  explicit Laws(std::ptrdiff_t n) : E(n, 3, 3), b(n, 3) {}
  void store(const Group& group, const RateLaw<Lanes>& law) {
    const RowMajor3<Lanes> rows = law.E;
    E.store(group, rows.data());
    b.store(group, law.b.data());
  }
  auto give() { return std::make_tuple(E.give(), b.give()); }
};

auto floating_laws(const OwnedRobot& owned, const Array& q_, const Array& qd_, const Array& D_free_,
                   const Array& h_spin_, bool planar, int threads) {
  const Robot robot = owned.view();
  const auto q = input<2>("q", q_, {ANY, robot.tree.joints});
  const std::ptrdiff_t n = q.size(0);
  const auto qd = input<2>("qd", qd_, {n, robot.tree.joints});
  const RowMajor3<double> D_free(input<2>("D_free", D_free_, {3, 3}).data());
  const Vector3<double> h_spin(input<1>("h_spin", h_spin_, {3}).data());
  Laws laws(n);
  {
    nb::gil_scoped_release release;
    each_group(robot, q, qd, threads, [&](const Group& group, const FloatingTerms<Lanes>& at) {
      laws.store(group, rate_law<Lanes>(at.D - D_free.cast<Lanes>(), at.h_q + h_spin.cast<Lanes>(),
                                        planar));
    });
  }
  return laws.give();
}

auto laws_of(const Array& D_, const Array& h_, bool planar, int threads) {
  const auto D = input<3>("D", D_, {ANY, 3, 3});
  const std::ptrdiff_t n = D.size(0);
  const auto h_moving = input<2>("h_moving", h_, {n, 3});
  Laws laws(n);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      by_groups(first, last, [&](const Group& group) {
        RowMajor3<Lanes> D_k;
        Vector3<Lanes> h_k;
        D.load(group, D_k.data());
        h_moving.load(group, h_k.data());
        laws.store(group, rate_law<Lanes>(D_k, h_k, planar));
      });
    });
  }
  return laws.give();
}

// The law and the momentum at many nodes.
struct Nodes {
  In<3> E;
  In<2> b, h_cm;
  FloatingNode<double> at(std::ptrdiff_t k) const {
    return {
        {Eigen::Map<const RowMajor3<double>>(E.data() + 9 * k), Vector3<double>(b.data() + 3 * k)},
        Vector3<double>(h_cm.data() + 3 * k)};
  }
  FloatingNode<Lanes> at(const Group& group) const {
    RowMajor3<Lanes> E_k;
    FloatingNode<Lanes> node;
    E.load(group, E_k.data());
    node.law.E = E_k;
    b.load(group, node.law.b.data());
    h_cm.load(group, node.h_cm.data());
    return node;
  }
};

Nodes nodes_of(const Array& E, const Array& b, const Array& h_cm, std::int64_t n) {
  return {input<3>("E", E, {n, 3, 3}), input<2>("b", b, {n, 3}), input<2>("h_cm", h_cm, {n, 3})};
}

auto attitudes(const Array& E, const Array& b, const Array& h_cm, const Array& x_, const Array& t_,
               int substeps) {
  if (substeps < 2 || substeps % 2 != 0)
    throw nb::value_error("substeps is not an even number of steps; give one of 2 or more");
  const auto t = input<1>("t", t_, {ANY});
  const std::ptrdiff_t samples = t.size(0);
  if (samples == 0) throw nb::value_error("t has no sample; give at least one");
  const Nodes nodes = nodes_of(E, b, h_cm, 2 * std::int64_t(substeps) * (samples - 1) + 1);
  Quaternion<double> fine(input<1>("x_WB", x_, {4}).data()), coarse = fine;
  Out<2> path(samples, 4);
  double apart = 0.0;
  {
    nb::gil_scoped_release release;
    Eigen::Map<Quaternion<double>>(path.data()) = fine;
    std::ptrdiff_t node = 0;
    for (std::ptrdiff_t k = 1; k < samples; ++k) {
      const double dt = (t.data()[k] - t.data()[k - 1]) / substeps;
      for (int step = 0; step < substeps; step += 2, node += 4) {
        const FloatingNode<double> start = nodes.at(node), middle = nodes.at(node + 2),
                                   end = nodes.at(node + 4);
        coarse = attitude_step(coarse, 2.0 * dt, start, middle, end);
        fine = attitude_step(fine, dt, start, nodes.at(node + 1), middle);
        fine = attitude_step(fine, dt, middle, nodes.at(node + 3), end);
      }
      Eigen::Map<Quaternion<double>>(path.data() + 4 * k) = fine;
      // What overflows is NaN from there on; then so is the largest.
      apart = std::max(small_rotation(coarse, fine).norm(), apart);
    }
  }
  return std::make_tuple(path.give(), 2.0 * std::asin(std::min(apart / 2.0, 1.0)));
}

auto motion(const OwnedRobot& owned, const Array& q_, const Array& qd_, const Array& E,
            const Array& b, const Array& h_cm, const Array& x_, int threads) {
  const Robot robot = owned.view();
  const auto q = input<2>("q", q_, {ANY, robot.tree.joints});
  const std::ptrdiff_t n = q.size(0);
  const auto qd = input<2>("qd", qd_, {n, robot.tree.joints});
  const Nodes nodes = nodes_of(E, b, h_cm, n);
  const auto x_WB = input<2>("x_WB", x_, {n, 4});
  Out<2> w(n, 3), r_S(n, 3), v_S(n, 3);
  {
    nb::gil_scoped_release release;
    each_group(robot, q, qd, threads, [&](const Group& group, const FloatingTerms<Lanes>& at) {
      const FloatingNode<Lanes> node = nodes.at(group);
      Quaternion<Lanes> x;
      x_WB.load(group, x.data());
      const Matrix3<Lanes> R_WB = quaternion_matrix(x);
      const Vector3<Lanes> w_k = node.law.rate(x, node.h_cm), r_k = -(R_WB * at.r_cm),
                           v_k = -(R_WB * (w_k.cross(at.r_cm) + at.v_q));
      w.store(group, w_k.data());
      r_S.store(group, r_k.data());
      v_S.store(group, v_k.data());
    });
  }
  return std::make_tuple(w.give(), r_S.give(), v_S.give());
}

}  // namespace

void bind_free_floating(nb::module_& m) {
  m.def("floating_laws", &floating_laws, nb::arg("robot"), nb::arg("q"), nb::arg("qd"),
        nb::arg("D_free"), nb::arg("h_spin"), nb::arg("planar"), nb::arg("threads") = 1,
        "E and b of w = E R_0^T h_cm - b, by (D - D_free) w + D_q qd + h_spin = R_0^T h_cm.");
  m.def("rate_laws", &laws_of, nb::arg("D"), nb::arg("h_moving"), nb::arg("planar"),
        nb::arg("threads") = 1, "The same by D w + h_moving = R_0^T h_cm.");
  m.def(
      "attitudes", &attitudes, nb::arg("E"), nb::arg("b"), nb::arg("h_cm"), nb::arg("x_WB"),
      nb::arg("t"), nb::arg("substeps"),
      "The attitude at the samples by so many RK4 steps between two of them, and the largest angle "
      "from what half as many give; nodes are the ends and middles of the steps.");
  m.def("floating_motion", &motion, nb::arg("robot"), nb::arg("q"), nb::arg("qd"), nb::arg("E"),
        nb::arg("b"), nb::arg("h_cm"), nb::arg("x_WB"), nb::arg("threads") = 1,
        "Base rate (base axes); r_S and v_S relative to the CM (inertial axes).");
}

}  // namespace orbident::python
