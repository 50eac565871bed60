// Kinematics, momentum regressors, inertia and equations of motion, over many states at once.
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "orbident/jet.hpp"
#include "orbident/no_heap.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

OwnedTree make_tree(const Array& parent, const Array& revolute, const Array& axis,
                    const Array& R_PJ, const Array& p_PJ) {
  const auto parents = input<1>("parent", parent, {ANY});
  const std::int64_t n = parents.size(0);
  const auto turns = input<1>("revolute", revolute, {n});
  const auto axes = input<2>("axis", axis, {n, 3});
  const auto R = input<3>("R_PJ", R_PJ, {n, 3, 3});
  const auto p = input<2>("p_PJ", p_PJ, {n, 3});
  OwnedTree tree;
  for (std::int64_t k = 0; k < n; ++k) {
    const double before = parents.data()[k];
    if (!(before >= 0 && before <= static_cast<double>(k)))
      throw nb::value_error("parent: a joint's parent body must come before the body it moves");
    tree.joints.push_back(
        {static_cast<int>(before), turns.data()[k] != 0.0,
         Eigen::Map<const Vector3<double>>(axes.data() + 3 * k),
         Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data() + 9 * k),
         Eigen::Map<const Vector3<double>>(p.data() + 3 * k)});
  }
  return tree;
}

OwnedRobot make_robot(const OwnedTree& tree, const Array& theta, const Array& armature,
                      const Array& axes, const Array& inertia) {
  const std::int64_t bodies = tree.view().bodies();
  const auto body = input<2>("theta", theta, {bodies, PER_BODY});
  const auto rotor = input<1>("armature", armature, {bodies - 1});
  const auto inertias = input<1>("wheel_inertia", inertia, {ANY});
  const auto axis = input<2>("wheel_axis", axes, {inertias.size(0), 3});
  OwnedRobot robot{tree,
                   {body.data(), body.data() + bodies * PER_BODY},
                   {rotor.data(), rotor.data() + bodies - 1},
                   {}};
  for (std::ptrdiff_t k = 0; k < inertias.size(0); ++k)
    robot.wheels.push_back(
        {Eigen::Map<const Vector3<double>>(axis.data() + 3 * k), inertias.data()[k]});
  return robot;
}

auto poses(const OwnedTree& owned, const Array& q_, int threads) {
  const Tree tree = owned.view();
  const auto q = input<2>("q", q_, {ANY, tree.joints});
  const std::ptrdiff_t n = q.size(0), B = tree.bodies();
  const std::ptrdiff_t K = tree.joints;
  Out<4> R(n, B, 3, 3);
  Out<3> d(n, B, 3), field_w(n, K, 3), field_u(n, K, 3);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      BodiesMemory<double> memory(tree);
      const NoHeap guard;
      for (std::ptrdiff_t k = first; k < last; ++k) {
        place(tree, q.data() + k * tree.joints, memory.at.pose, memory.at.field);
        for (std::ptrdiff_t i = 0; i < B; ++i) {
          Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data() + 9 * (k * B + i)) =
              memory.at.pose[i].R;
          Eigen::Map<Vector3<double>>(d.data() + 3 * (k * B + i)) = memory.at.pose[i].d;
        }
        for (std::ptrdiff_t i = 0; i < K; ++i) {
          Eigen::Map<Vector3<double>>(field_w.data() + 3 * (k * K + i)) = memory.at.field[i].w;
          Eigen::Map<Vector3<double>>(field_u.data() + 3 * (k * K + i)) = memory.at.field[i].u;
        }
      }
    });
  }
  return std::make_tuple(R.give(), d.give(), field_w.give(), field_u.give());
}

auto momentum(const OwnedTree& owned, const Array& q_, const Array& qd_, const Array& w_,
              int threads) {
  const Tree tree = owned.view();
  const auto q = input<2>("q", q_, {ANY, tree.joints});
  const std::ptrdiff_t n = q.size(0), m = PER_BODY * tree.bodies();
  const auto qd = input<2>("qd", qd_, {n, tree.joints});
  const auto w = input<2>("w", w_, {n, 3});
  Out<3> S(n, 3, m), P(n, 3, m), A(n, 3, m);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      MovingBodies bodies(tree, q, qd, w);
      OwnedRows<Lanes> S_k(m), P_k(m), A_k(m);
      const NoHeap guard;
      by_groups(first, last, [&](const Group& group) {
        const Bodies<Lanes>& at = bodies.at(group);
        first_moment_columns(tree, at.pose, S_k.view);
        momentum_columns(tree, at.pose, at.motion, P_k.view, A_k.view);
        S.store(group, S_k.numbers.data());
        P.store(group, P_k.numbers.data());
        A.store(group, A_k.numbers.data());
      });
    });
  }
  return std::make_tuple(S.give(), P.give(), A.give());
}

// Mass, first moment and inertia about S, of each body or of all that each body carries.
auto masses(const OwnedRobot& owned, const Array& q_, bool carried) {
  const Robot robot = owned.view();
  const std::ptrdiff_t K = robot.tree.joints, B = robot.tree.bodies();
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t n = q.size(0);
  Out<2> m(n, B);
  Out<3> s(n, B, 3);
  Out<4> J(n, B, 3, 3);
  BodiesMemory<double> memory(robot.tree);
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    configure(robot, q.data() + k * K, memory.at);
    for (std::ptrdiff_t i = 0; i < B; ++i) {
      const Mass<double>& body = carried ? memory.at.carried[i] : memory.at.mass[i];
      m.data()[k * B + i] = body.m;
      Eigen::Map<Vector3<double>>(s.data() + 3 * (k * B + i)) = body.s;
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(J.data() + 9 * (k * B + i)) = body.J;
    }
  }
  return std::make_tuple(m.give(), s.give(), J.give());
}

auto inertia(const OwnedRobot& owned, const Array& q_, int threads) {
  const Robot robot = owned.view();
  const std::ptrdiff_t K = robot.tree.joints;
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t n = q.size(0);
  Out<3> D(n, 3, 3), D_q(n, 3, K), D_qq(n, K, K), J_cm(n, 3, K);
  Out<2> r_cm(n, 3);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      BodiesMemory<double> memory(robot.tree);
      Bodies<double>& at = memory.at;
      const NoHeap guard;
      for (std::ptrdiff_t k = first; k < last; ++k) {
        configure(robot, q.data() + k * K, at);
        const auto all = system_inertia(at.carried[0]);
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(D.data() + 9 * k) = all.D;
        Eigen::Map<Vector3<double>>(r_cm.data() + 3 * k) = all.r_cm;
        joint_columns(robot.tree, at.field, at.carried, at.momentum,
                      Rows3<double>(D_q.data() + 3 * K * k, 3, K),
                      Rows3<double>(J_cm.data() + 3 * K * k, 3, K));
        joint_block(robot, at, Square<double>(D_qq.data() + K * K * k, K, K));
      }
    });
  }
  return std::make_tuple(D.give(), D_q.give(), D_qq.give(), r_cm.give(), J_cm.give());
}

auto equations_of_motion(const OwnedRobot& owned, const Array& q_, const Array& v_, int threads) {
  const Robot robot = owned.view();
  const std::ptrdiff_t K = robot.tree.joints, N = robot.speeds();
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t n = q.size(0);
  const auto v = input<2>("v", v_, {n, N});
  Out<3> H(n, N, N);
  Out<2> c(n, N), f_S(n, 3);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      BodiesMemory<Lanes> memory(robot.tree);
      std::vector<Lanes> q_k = room<Lanes>(K), v_k = room<Lanes>(N), H_k = room<Lanes>(N * N),
                         c_k = room<Lanes>(N);
      const NoHeap guard;
      by_groups(first, last, [&](const Group& group) {
        q.load(group, q_k.data());
        v.load(group, v_k.data());
        configure(robot, q_k.data(), memory.at);
        mass_matrix(robot, memory.at, Square<Lanes>(H_k.data(), N, N));
        const Vector3<Lanes> f_k = bias(robot, v_k.data(), memory.at, Column<Lanes>(c_k.data(), N));
        H.store(group, H_k.data());
        c.store(group, c_k.data());
        f_S.store(group, f_k.data());
      });
    });
  }
  return std::make_tuple(H.give(), c.give(), f_S.give());
}

// Directions that are derived along at once: two vector registers of doubles.
constexpr int DIRECTIONS = 4;
using Along = Jet<DIRECTIONS>;

// Standard deviations of H+ and c+, to first order, where theta = theta_0 + sum_k x_k direction_k
// with independent x_k of unit variance: the root of the sum of squares of the derivatives.
auto deviations(const OwnedRobot& owned, const Array& directions_, const Array& q_, const Array& v_,
                int threads) {
  const Robot robot = owned.view();
  const std::ptrdiff_t K = robot.tree.joints, N = robot.speeds();
  const std::ptrdiff_t size = PER_BODY * robot.tree.bodies();
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t n = q.size(0);
  const auto v = input<2>("v", v_, {n, N});
  const auto directions = input<3>("directions", directions_, {ANY, robot.tree.bodies(), PER_BODY});
  const std::ptrdiff_t many = directions.size(0);
  Out<3> H_std(n, N, N);
  Out<2> c_std(n, N);
  {
    nb::gil_scoped_release release;
    std::fill_n(H_std.data(), n * N * N, 0.0);
    std::fill_n(c_std.data(), n * N, 0.0);
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      BodiesMemory<Along> memory(robot.tree);
      Bodies<Along>& at = memory.at;
      std::vector<Along> theta = room<Along>(size), H = room<Along>(N * N), c = room<Along>(N),
                         q_k = room<Along>(K), v_k = room<Along>(N);
      const NoHeap guard;
      for (std::ptrdiff_t k = first; k < last; ++k) {
        std::copy_n(q.data() + k * K, K, q_k.begin());
        std::copy_n(v.data() + k * N, N, v_k.begin());
        place(robot.tree, q_k.data(), at.pose, at.field);
        for (std::ptrdiff_t d = 0; d < many; d += DIRECTIONS) {
          for (std::ptrdiff_t i = 0; i < size; ++i) {
            theta[static_cast<std::size_t>(i)] = robot.theta[i];
            for (int j = 0; j < DIRECTIONS && d + j < many; ++j)
              theta[static_cast<std::size_t>(i)].v[j] = directions.data()[(d + j) * size + i];
          }
          weigh(robot.tree, theta.data(), at.pose, at.mass);
          finish(robot, at);
          mass_matrix(robot, at, Square<Along>(H.data(), N, N));
          bias(robot, v_k.data(), at, Column<Along>(c.data(), N));
          for (std::ptrdiff_t i = 0; i < N * N; ++i)
            H_std.data()[k * N * N + i] += H[static_cast<std::size_t>(i)].v.square().sum();
          for (std::ptrdiff_t i = 0; i < N; ++i)
            c_std.data()[k * N + i] += c[static_cast<std::size_t>(i)].v.square().sum();
        }
      }
    }, 1);
    for (std::ptrdiff_t i = 0; i < n * N * N; ++i) H_std.data()[i] = std::sqrt(H_std.data()[i]);
    for (std::ptrdiff_t i = 0; i < n * N; ++i) c_std.data()[i] = std::sqrt(c_std.data()[i]);
  }
  return std::make_tuple(H_std.give(), c_std.give());
}

}  // namespace

void bind_dynamics(nb::module_& m) {
  nb::class_<OwnedTree>(m, "Tree", "A robot's kinematic tree; joint k moves body k + 1.")
      .def(nb::new_(&make_tree), nb::arg("parent"), nb::arg("revolute"), nb::arg("axis"),
           nb::arg("R_PJ"), nb::arg("p_PJ"))
      .def_prop_ro("joints", [](const OwnedTree& tree) { return tree.joints.size(); });
  nb::class_<OwnedRobot>(m, "Robot", "A tree with its inertia theta, motors' rotors and wheels.")
      .def(nb::new_(&make_robot), nb::arg("tree"), nb::arg("theta"), nb::arg("armature"),
           nb::arg("wheel_axis"), nb::arg("wheel_inertia"));
  m.def("poses", &poses, nb::arg("tree"), nb::arg("q"), nb::arg("threads") = 1,
        "R_Bi and p_SBi of all bodies and the motion (w, u at S) of each joint at unit rate; base "
        "axes.");
  m.def("momentum", &momentum, nb::arg("tree"), nb::arg("q"), nb::arg("qd"), nb::arg("w"),
        nb::arg("threads") = 1, "The momentum regressors S, P and A (Eqs. 3, 19).");
  m.def("masses", &masses, nb::arg("robot"), nb::arg("q"), nb::arg("carried"),
        "Mass, first moment and inertia about S of each body, or of all that it carries.");
  m.def("inertia", &inertia, nb::arg("robot"), nb::arg("q"), nb::arg("threads") = 1,
        "D, D_q, D_qq, r_cm and J_cm (Eqs. 3, 6, 30).");
  m.def("equations_of_motion", &equations_of_motion, nb::arg("robot"), nb::arg("q"), nb::arg("v"),
        nb::arg("threads") = 1, "H+, c+ (Eqs. 13, 14), and the acceleration of S where v' = 0.");
  m.def("deviations", &deviations, nb::arg("robot"), nb::arg("directions"), nb::arg("q"),
        nb::arg("v"), nb::arg("threads") = 1,
        "Standard deviations of H+ and c+ along independent directions of theta.");
}

}  // namespace orbident::python
