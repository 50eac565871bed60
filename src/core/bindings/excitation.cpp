// The base's motion along joint motions that are tried, and the gradient of what is made small.
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "orbident/excitation.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

struct OwnedFloating {
  OwnedRobot robot;
  Floating floating;
  Floating view() const {
    Floating at = floating;
    at.robot = robot.view();
    return at;
  }
};

// The laws of the base rate along one joint motion, at nodes and mid-nodes.
struct Laws {
  std::vector<NodeLaw> at;
};

using In3 = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>;

Vector3<double> vector(const double* data) { return Eigen::Map<const Vector3<double>>(data); }

OwnedFloating make_floating(const OwnedRobot& robot, bool planar, const Array& D_free_,
                            const Array& h_rw, const Array& h_cm, const Array& x_WB) {
  const auto D_free = input<2>("D_free", D_free_, {3, 3});
  return {robot,
          {robot.view(), planar,
           Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(D_free.data()),
           vector(input<1>("h_rw", h_rw, {3}).data()), vector(input<1>("h_cm", h_cm, {3}).data()),
           Eigen::Map<const Quaternion<double>>(input<1>("x_WB", x_WB, {4}).data())}};
}

std::ptrdiff_t steps_of(std::ptrdiff_t nodes) {
  if (nodes % 2 == 0) throw nb::value_error("q: give nodes and mid-nodes, an odd number of rows");
  return nodes / 2;
}

Laws laws_at(const Floating& floating, const double* q, const double* qd, std::ptrdiff_t nodes,
             int threads) {
  const std::ptrdiff_t K = floating.robot.tree.joints;
  Laws laws{std::vector<NodeLaw>(static_cast<std::size_t>(nodes))};
  parallel_for(nodes, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    BodiesMemory<double> memory(floating.robot.tree);
    for (std::ptrdiff_t k = first; k < last; ++k) {
      configure(floating.robot, q + k * K, memory.at);
      laws.at[static_cast<std::size_t>(k)] = node_law(floating, memory.at, qd + k * K);
    }
  });
  return laws;
}

auto float_along(const OwnedFloating& owned, const Array& q_, const Array& qd_, double dt,
                 int threads) {
  const Floating floating = owned.view();
  const std::int64_t K = floating.robot.tree.joints;
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t nodes = q.size(0), n = steps_of(nodes);
  const auto qd = input<2>("qd", qd_, {nodes, K});
  Out<2> w(n + 1, 3), x_WB(n + 1, 4);
  Laws laws;
  {
    nb::gil_scoped_release release;
    laws = laws_at(floating, q.data(), qd.data(), nodes, threads);
    Quaternion<double> x = floating.x_WB;
    for (std::ptrdiff_t k = 0; k <= n; ++k) {
      const NodeLaw* law = laws.at.data() + 2 * k;
      Eigen::Map<Quaternion<double>>(x_WB.data() + 4 * k) = x;
      Eigen::Map<Vector3<double>>(w.data() + 3 * k) = law->rate(x, floating.h_cm);
      if (k < n) x = Step(law, floating.h_cm, dt, x).end.normalized();
    }
  }
  return std::make_tuple(w.give(), x_WB.give(), std::move(laws));
}

// Memory for the gradient at one node.
struct NodeMemory {
  BodiesMemory<double> bodies;
  std::vector<Motion<double>> wrench;
  std::vector<double> columns;
  std::vector<double> still, unused;  // joint rates of zero, and a gradient that is not needed
  Wrenches wrenches;
  Rows3<double> S, P, A;
  RegressorGradients gradients;

  NodeMemory(const Tree& tree, std::ptrdiff_t phis)
      : bodies(tree),
        wrench(static_cast<std::size_t>(2 * tree.bodies())),
        columns(static_cast<std::size_t>(6 * 3 * PER_BODY * tree.bodies() + 4 * 3 * phis)),
        still(static_cast<std::size_t>(tree.joints), 0.0),
        unused(still),
        wrenches{wrench.data(), wrench.data() + tree.bodies()},
        S(theta(0, tree)),
        P(theta(1, tree)),
        A(theta(2, tree)),
        gradients{phi(0, tree, phis), phi(1, tree, phis), phi(2, tree, phis), phi(3, tree, phis),
                  theta(3, tree),     theta(4, tree),     theta(5, tree)} {}

 private:
  Rows3<double> theta(int k, const Tree& tree) {
    const std::ptrdiff_t m = PER_BODY * tree.bodies();
    return {columns.data() + 3 * m * k, 3, m};
  }
  Rows3<double> phi(int k, const Tree& tree, std::ptrdiff_t phis) {
    return {columns.data() + 18 * PER_BODY * tree.bodies() + 3 * phis * k, 3, phis};
  }
};

// What reaches the attitude at a node: its momentum stages (weight a at rate w), two at most.
struct NodeStages {
  Vector3<double> a[2] = {Vector3<double>::Zero(), Vector3<double>::Zero()};
  Vector3<double> w[2] = {Vector3<double>::Zero(), Vector3<double>::Zero()};
};

// From the gradients at the nodes back through the attitude; f_w is df/dw, f_turn that of a small
// rotation of the base.
std::vector<NodeStages> reverse_attitude(const Floating& floating, const Laws& laws,
                                         const double* x_WB, const double* w, double dt,
                                         std::ptrdiff_t n, const double* f_w,
                                         const double* f_turn) {
  std::vector<NodeStages> stages(laws.at.size());
  Quaternion<double> f_x = Quaternion<double>::Zero();
  for (std::ptrdiff_t k = n; k >= 0; --k) {
    const NodeLaw* law = laws.at.data() + 2 * k;
    NodeStages* here = stages.data() + 2 * k;
    const Quaternion<double> x = Eigen::Map<const Quaternion<double>>(x_WB + 4 * k);
    here[0].w[0] = vector(w + 3 * k);
    if (k < n) {
      Step step(law, floating.h_cm, dt, x);
      f_x = step.reverse(f_x);
      here[0].a[0] = step.stage[0].a;
      here[1] = {{step.stage[1].a, step.stage[2].a}, {step.stage[1].w, step.stage[2].w}};
      here[2].a[1] = step.stage[3].a;
      here[2].w[1] = step.stage[3].w;
    }
    const Vector3<double> a = law->E * vector(f_w + 3 * k);
    const Vector3<double> h_B = quaternion_matrix(x).transpose() * floating.h_cm;
    f_x += rotation_gradient(x, vector(f_turn + 3 * k) + a.cross(h_B));
    here[0].a[0] += a;
  }
  return stages;
}

auto float_gradient(const OwnedFloating& owned, const Laws& laws,
                    const OwnedMinimalSets& owned_sets, const Array& q_, const Array& qd_,
                    double dt, const Array& w_, const Array& x_WB_, const Array& f_Y_,
                    const Array& f_W_, const Array& f_D_, const Array& f_r_, const Array& f_w_,
                    const Array& f_turn_, int threads) {
  const Floating floating = owned.view();
  const Robot& robot = floating.robot;
  const MinimalSets sets = owned_sets.view();
  const std::int64_t K = robot.tree.joints, pis = sets.pis(), phis = sets.phis();
  if (owned_sets.tree.view().joints != K) throw nb::value_error("sets: they are of another robot");
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t nodes = q.size(0), n = steps_of(nodes), m = n + 1;
  if (nodes != static_cast<std::ptrdiff_t>(laws.at.size()))
    throw nb::value_error("laws: give those of this motion, one for each row of q");
  const auto qd = input<2>("qd", qd_, {nodes, K});
  const auto w = input<2>("w", w_, {m, 3}), x_WB = input<2>("x_WB", x_WB_, {m, 4});
  const auto f_Y = input<3>("f_Y", f_Y_, {m, 3, pis}), f_W = input<3>("f_W", f_W_, {m, 3, phis});
  const auto f_D = input<3>("f_D", f_D_, {m, 3, 3});
  const auto f_r = input<2>("f_r", f_r_, {m, 3}), f_w = input<2>("f_w", f_w_, {m, 3});
  const auto f_turn = input<2>("f_turn", f_turn_, {m, 3});
  Out<2> f_q(nodes, K), f_qd(nodes, K);
  std::fill_n(f_q.data(), nodes * K, 0.0);
  std::fill_n(f_qd.data(), nodes * K, 0.0);
  {
    nb::gil_scoped_release release;
    const Vector3<double> none = Vector3<double>::Zero();
    std::vector<double> to_w(f_w.data(), f_w.data() + 3 * m);
    // Y and W of a node, its D and r_cm.
    parallel_for(m, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      NodeMemory memory(robot.tree, phis);
      Bodies<double>& at = memory.bodies.at;
      const auto wrenches = [&](int i, Motion<double>& turn, Motion<double>& rate) {
        body_wrenches(memory.gradients.of(i), at.pose[i], at.motion[i], turn, rate);
      };
      for (std::ptrdiff_t k = first; k < last; ++k) {
        const double *q_k = q.data() + 2 * k * K, *qd_k = qd.data() + 2 * k * K;
        double *f_q_k = f_q.data() + 2 * k * K, *f_qd_k = f_qd.data() + 2 * k * K;
        const Vector3<double> w_k = vector(w.data() + 3 * k);
        configure(robot, q_k, at);
        move(robot.tree, at.field, w_k, qd_k, at.motion);
        first_moment_columns(robot.tree, at.pose, memory.S);
        momentum_columns(robot.tree, at.pose, at.motion, memory.P, memory.A);
        regressor_gradients(sets, memory.S, memory.P, In3(f_Y.data() + 3 * pis * k, 3, pis),
                            In3(f_W.data() + 3 * phis * k, 3, phis), memory.gradients);
        Eigen::Map<Vector3<double>>(to_w.data() + 3 * k) +=
            momentum_adjoint(robot.tree, at.field, qd_k, wrenches, memory.wrenches, f_q_k, f_qd_k);
        // D e_i is h_rs at the unit rate e_i.
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_D(f_D.data() +
                                                                                  9 * k);
        Vector3<double> r = vector(f_r.data() + 3 * k);
        for (int i = 0; i < 3 && (!by_D.isZero(0) || !r.isZero(0)); ++i, r = none)
          add_momentum_gradient(robot, at, memory.wrenches, by_D.col(i), r, none,
                                Vector3<double>::Unit(i), memory.still.data(), f_q_k,
                                memory.unused.data());
      }
    });
    const std::vector<NodeStages> stages =
        reverse_attitude(floating, laws, x_WB.data(), w.data(), dt, n, to_w.data(), f_turn.data());
    parallel_for(nodes, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      NodeMemory memory(robot.tree, phis);
      for (std::ptrdiff_t k = first; k < last; ++k) {
        configure(robot, q.data() + k * K, memory.bodies.at);
        const NodeStages& here = stages[static_cast<std::size_t>(k)];
        for (int s = 0; s < 2; ++s)
          add_momentum_gradient(robot, memory.bodies.at, memory.wrenches, -here.a[s], none, none,
                                here.w[s], qd.data() + k * K, f_q.data() + k * K,
                                f_qd.data() + k * K);
      }
    });
  }
  return std::make_tuple(f_q.give(), f_qd.give());
}

auto momentum_gradient(const OwnedRobot& owned, const Array& q_, const Array& qd_, const Array& w_,
                       const Array& a_, const Array& v_, int threads) {
  const Robot robot = owned.view();
  const std::int64_t K = robot.tree.joints;
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t n = q.size(0);
  const auto qd = input<2>("qd", qd_, {n, K});
  const auto w = input<2>("w", w_, {n, 3}), a = input<2>("a", a_, {n, 3});
  const auto v = input<2>("v", v_, {n, 3});
  Out<2> f_q(n, K), f_qd(n, K), f_w(n, 3);
  std::fill_n(f_q.data(), n * K, 0.0);
  std::fill_n(f_qd.data(), n * K, 0.0);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      NodeMemory memory(robot.tree, 0);
      for (std::ptrdiff_t k = first; k < last; ++k) {
        configure(robot, q.data() + k * K, memory.bodies.at);
        Eigen::Map<Vector3<double>>(f_w.data() + 3 * k) = add_momentum_gradient(
            robot, memory.bodies.at, memory.wrenches, vector(a.data() + 3 * k),
            Vector3<double>::Zero(), vector(v.data() + 3 * k), vector(w.data() + 3 * k),
            qd.data() + k * K, f_q.data() + k * K, f_qd.data() + k * K);
      }
    });
  }
  return std::make_tuple(f_q.give(), f_qd.give(), f_w.give());
}

}  // namespace

void bind_excitation(nb::module_& m) {
  nb::class_<OwnedFloating>(m, "Floating", "A robot that floats, and its constant momentum.")
      .def(nb::new_(&make_floating), nb::arg("robot"), nb::arg("planar"), nb::arg("D_free"),
           nb::arg("h_rw"), nb::arg("h_cm"), nb::arg("x_WB"));
  nb::class_<Laws>(m, "RateLaws", "How the base rate follows from the attitude, node by node.");
  m.def("float_along", &float_along, nb::arg("floating"), nb::arg("q"), nb::arg("qd"),
        nb::arg("dt"), nb::arg("threads") = 1,
        "Base rate and attitude at every second of the nodes, by RK4; the laws at all of them.");
  m.def("float_gradient", &float_gradient, nb::arg("floating"), nb::arg("laws"), nb::arg("sets"),
        nb::arg("q"), nb::arg("qd"), nb::arg("dt"), nb::arg("w"), nb::arg("x_WB"), nb::arg("f_Y"),
        nb::arg("f_W"), nb::arg("f_D"), nb::arg("f_r"), nb::arg("f_w"), nb::arg("f_turn"),
        nb::arg("threads") = 1,
        "df/dq and df/dqd at all nodes, from the gradients of f by Y, W, D, r_cm, w and a small "
        "rotation of the base at every second one.");
  m.def("momentum_gradient", &momentum_gradient, nb::arg("robot"), nb::arg("q"), nb::arg("qd"),
        nb::arg("w"), nb::arg("a"), nb::arg("v"), nb::arg("threads") = 1,
        "The gradients by q, qd and w of a . h_rs + v . (w x r_cm + J_cm qd), state by state.");
}

}  // namespace orbident::python
