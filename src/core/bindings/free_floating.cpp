// Free floating over many joint states, and the attitude along them.
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "orbident/free_floating.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// One after another: the terms at many joint states.
template <class Use>
void each_state(const Robot& robot, const double* q, const double* qd, std::ptrdiff_t n,
                int threads, Use&& use) {
  const std::ptrdiff_t K = robot.tree.joints;
  parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    BodiesMemory<double> memory(robot.tree);
    const Bodies<double>& at = memory.at;
    for (std::ptrdiff_t k = first; k < last; ++k)
      use(k, floating_terms(robot.tree, robot.theta, q + k * K, qd + k * K, at.pose, at.field,
                            at.motion, at.mass));
  });
}

// E and b at many times.
struct Laws {
  Out<3> E;
  Out<2> b;
  explicit Laws(std::ptrdiff_t n) : E(n, 3, 3), b(n, 3) {}
  void set(std::ptrdiff_t k, const RateLaw<double>& law) {
    Eigen::Map<RowMajor3>(E.data() + 9 * k) = law.E;
    Eigen::Map<Vector3<double>>(b.data() + 3 * k) = law.b;
  }
  auto give() { return std::make_tuple(E.give(), b.give()); }
};

auto floating_laws(const OwnedRobot& owned, const Array& q_, const Array& qd_, const Array& D_free_,
                   const Array& h_spin_, bool planar, int threads) {
  const Robot robot = owned.view();
  const auto q = input<2>("q", q_, {ANY, robot.tree.joints});
  const std::ptrdiff_t n = q.size(0);
  const auto qd = input<2>("qd", qd_, {n, robot.tree.joints});
  const RowMajor3 D_free(input<2>("D_free", D_free_, {3, 3}).data());
  const Vector3<double> h_spin(input<1>("h_spin", h_spin_, {3}).data());
  Laws laws(n);
  {
    nb::gil_scoped_release release;
    each_state(robot, q.data(), qd.data(), n, threads,
               [&](std::ptrdiff_t k, const FloatingTerms<double>& at) {
                 laws.set(k, rate_law<double>(at.D - D_free, at.h_q + h_spin, planar));
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
      for (std::ptrdiff_t k = first; k < last; ++k)
        laws.set(k, rate_law<double>(Eigen::Map<const RowMajor3>(D.data() + 9 * k),
                                     Vector3<double>(h_moving.data() + 3 * k), planar));
    });
  }
  return laws.give();
}

// The law and the momentum at many nodes.
struct Nodes {
  In<3> E;
  In<2> b, h_cm;
  FloatingNode<double> at(std::ptrdiff_t k) const {
    return {{Eigen::Map<const RowMajor3>(E.data() + 9 * k), Vector3<double>(b.data() + 3 * k)},
            Vector3<double>(h_cm.data() + 3 * k)};
  }
};

Nodes nodes_of(const Array& E, const Array& b, const Array& h_cm, std::int64_t n) {
  return {input<3>("E", E, {n, 3, 3}), input<2>("b", b, {n, 3}), input<2>("h_cm", h_cm, {n, 3})};
}

auto attitudes(const Array& E, const Array& b, const Array& h_cm, const Array& x_, const Array& dt_) {
  const auto dt = input<1>("dt", dt_, {ANY});
  const std::ptrdiff_t steps = dt.size(0);
  const Nodes nodes = nodes_of(E, b, h_cm, 2 * steps + 1);
  Quaternion<double> x(input<1>("x_WB", x_, {4}).data());
  Out<2> path(steps + 1, 4);
  {
    nb::gil_scoped_release release;
    FloatingNode<double> start = nodes.at(0);
    Eigen::Map<Quaternion<double>>(path.data()) = x;
    for (std::ptrdiff_t k = 0; k < steps; ++k) {
      const FloatingNode<double> end = nodes.at(2 * k + 2);
      x = attitude_step(x, dt.data()[k], start, nodes.at(2 * k + 1), end);
      Eigen::Map<Quaternion<double>>(path.data() + 4 * (k + 1)) = x;
      start = end;
    }
  }
  return path.give();
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
    each_state(robot, q.data(), qd.data(), n, threads,
               [&](std::ptrdiff_t k, const FloatingTerms<double>& at) {
                 const FloatingNode<double> node = nodes.at(k);
                 const Quaternion<double> x(x_WB.data() + 4 * k);
                 const Matrix3<double> R_WB = quaternion_matrix(x);
                 const Vector3<double> rate = node.law.rate(x, node.h_cm);
                 Eigen::Map<Vector3<double>>(w.data() + 3 * k) = rate;
                 Eigen::Map<Vector3<double>>(r_S.data() + 3 * k) = -(R_WB * at.r_cm);
                 Eigen::Map<Vector3<double>>(v_S.data() + 3 * k) =
                     -(R_WB * (rate.cross(at.r_cm) + at.v_q));
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
  m.def("attitudes", &attitudes, nb::arg("E"), nb::arg("b"), nb::arg("h_cm"), nb::arg("x_WB"),
        nb::arg("dt"), "The attitude after each RK4 step; nodes are their ends and middles.");
  m.def("floating_motion", &motion, nb::arg("robot"), nb::arg("q"), nb::arg("qd"), nb::arg("E"),
        nb::arg("b"), nb::arg("h_cm"), nb::arg("x_WB"), nb::arg("threads") = 1,
        "Base rate (base axes); r_S and v_S relative to the CM (inertial axes).");
}

}  // namespace orbident::python
