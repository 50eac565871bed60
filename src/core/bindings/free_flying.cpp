// Forward dynamics of many states, and free-flying motion.
#include "orbident/free_flying.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <optional>

#include "arrays.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

auto forward(const OwnedRobot& owned, const Array& q_, const Array& v_, const Array& Q_,
             const Array& vd_, const Array& free_, int threads) {
  const Robot robot = owned.view();
  const std::ptrdiff_t K = robot.tree.joints, N = robot.speeds();
  const auto q = input<2>("q", q_, {ANY, K});
  const std::ptrdiff_t n = q.size(0);
  const auto v = input<2>("v", v_, {n, N});
  const auto Q = input<2>("Q", Q_, {n, N});
  const auto known = input<2>("vd", vd_, {n, N});
  const auto free = input<1>("free", free_, {N});
  Out<2> vd(n, N), f_S(n, 3);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      EquationsMemory<double> memory(robot);
      EquationsOfMotion<double>& eq = memory.eq;
      for (std::ptrdiff_t k = first; k < last; ++k) {
        set_up(robot, q.data() + k * K, v.data() + k * N, eq);
        std::copy_n(Q.data() + k * N, N, eq.Q);
        double* a = std::copy_n(known.data() + k * N, N, vd.data() + k * N) - N;
        accelerate(robot, free.data(), eq, a);
        Eigen::Map<Vector3<double>>(f_S.data() + 3 * k) = at_S(robot, eq.at, a) + eq.f_S;
      }
    });
  }
  return std::make_tuple(vd.give(), f_S.give());
}

using Values = std::vector<double>;

Values copy(const DoublesIn& array) { return {array.data(), array.data() + array.size()}; }

struct OwnedComputedTorque {
  OwnedRobot model;
  Values of_momentum;
  double kp, kd;
};

OwnedComputedTorque make_computed(const OwnedRobot& model, const Array& of_momentum, double kp,
                                  double kd) {
  const std::int64_t wheels = model.view().wheels;
  return {model, copy(input<2>("of_momentum", of_momentum, {wheels, 3}).array), kp, kd};
}

struct OwnedVehicle {
  OwnedRobot robot;
  Values free, Kp, Kd, k, speed, share, torque_limit, speed_limit;
  double kp, kd;
  Quaternion<double> x_WD;
  std::vector<BodyPoint> points;
  std::optional<OwnedComputedTorque> computed;
};

OwnedVehicle make_vehicle(const OwnedRobot& robot, const Array& free, const Array& Kp,
                          const Array& Kd, const Array& k, const Array& speed, const Array& share,
                          double kp, double kd, const Array& x_WD, const Array& torque_limit,
                          const Array& speed_limit, const Array& body, const Array& point,
                          std::optional<OwnedComputedTorque> computed) {
  const Robot view = robot.view();
  const std::int64_t K = view.tree.joints, W = view.wheels;
  const auto bodies = input<1>("body", body, {ANY});
  const auto at = input<2>("point", point, {bodies.size(0), 3});
  std::vector<BodyPoint> points;
  for (std::ptrdiff_t i = 0; i < bodies.size(0); ++i) {
    const double index = bodies.data()[i];
    if (!(index >= 0 && index < view.tree.bodies()))
      throw nb::value_error("body: a wrench acts on a body that the robot does not have");
    points.push_back({static_cast<int>(index), Vector3<double>(at.data() + 3 * i)});
  }
  if (computed && (computed->model.view().tree.joints != K || computed->model.view().wheels != W))
    throw nb::value_error("computed: its model has not the robot's joints and wheels");
  return {robot,
          copy(input<1>("free", free, {view.speeds()}).array),
          copy(input<1>("Kp", Kp, {K}).array),
          copy(input<1>("Kd", Kd, {K}).array),
          copy(input<1>("k", k, {W}).array),
          copy(input<1>("speed", speed, {W}).array),
          copy(input<2>("share", share, {W, 3}).array),
          copy(input<1>("torque_limit", torque_limit, {W}).array),
          copy(input<1>("speed_limit", speed_limit, {W}).array),
          kp,
          kd,
          Quaternion<double>(input<1>("x_WD", x_WD, {4}).data()),
          std::move(points),
          std::move(computed)};
}

// What is seen at the start of a step: its arrays, one row a shown step.
struct Shown {
  Out<2> q, x_WB, q_rw, v, vd, r_cm, r_S, v_cm, v_S, f_S, h_cm, tau, tau_rw;
  Shown(const Robot& robot, std::ptrdiff_t n)
      : q(n, robot.tree.joints),
        x_WB(n, 4),
        q_rw(n, robot.wheels),
        v(n, robot.speeds()),
        vd(n, robot.speeds()),
        r_cm(n, 3),
        r_S(n, 3),
        v_cm(n, 3),
        v_S(n, 3),
        f_S(n, 3),
        h_cm(n, 3),
        tau(n, robot.tree.joints),
        tau_rw(n, robot.wheels) {}

  void set(std::ptrdiff_t row, const Robot& robot, const double* state,
           const FlightMemory& memory) {
    const int N = robot.speeds(), joints = robot.tree.joints;
    const auto put = [row](Out<2>& to, const double* from) {
      std::copy_n(from, to.shape()[1], to.data() + static_cast<std::size_t>(row) * to.shape()[1]);
    };
    const auto put_vector = [put](Out<2>& to, const Vector3<double>& from) {
      put(to, from.data());
    };
    const Flying<const double> x(robot, state);
    const EquationsOfMotion<double>& eq = memory.plant;
    const Matrix3<double> R_WB = quaternion_matrix(Quaternion<double>(x.x_WB));
    const Eigen::Map<const Eigen::VectorXd> v_all(x.v, N), vd_all(memory.vd, N);
    const Square<double> H(eq.H, N, N);
    const Vector3<double> r_cm = eq.at.carried[0].s / eq.at.carried[0].m;
    put(q, x.q);
    put(x_WB, x.x_WB);
    put(q_rw, x.q_rw);
    put(v, x.v);
    put(vd, memory.vd);
    put(this->r_cm, x.r_cm);
    put_vector(r_S, Vector3<double>(x.r_cm) - R_WB * r_cm);
    put_vector(v_cm, R_WB * Vector3<double>(x.v));
    put_vector(v_S, R_WB * at_S(robot, eq.at, x.v));
    put_vector(f_S, at_S(robot, eq.at, memory.vd) + eq.f_S);
    put_vector(h_cm, R_WB * (H.middleRows<3>(3) * v_all));
    put(tau, memory.tau);
    // Eq. 12; of a held wheel, the torque that holds it.
    for (int k = 0; k < robot.wheels; ++k)
      tau_rw.data()[row * robot.wheels + k] = H.row(6 + joints + k).dot(vd_all);
  }

  auto give() {
    return std::make_tuple(q.give(), x_WB.give(), q_rw.give(), v.give(), vd.give(), r_cm.give(),
                           r_S.give(), v_cm.give(), v_S.give(), f_S.give(), h_cm.give(), tau.give(),
                           tau_rw.give());
  }
};

auto fly(const OwnedVehicle& owned, const Array& state_, const Array& dt_, const Array& command_,
         const Array& shown_) {
  ComputedTorque computed{};
  if (owned.computed)
    computed = {owned.computed->model.view(), owned.computed->of_momentum.data(),
                owned.computed->kp, owned.computed->kd};
  const Vehicle vehicle{
      owned.robot.view(),
      owned.free.data(),
      {owned.Kp.data(), owned.Kd.data(), owned.k.data(), owned.speed.data(), owned.share.data(),
       owned.kp, owned.kd, owned.x_WD, owned.computed ? &computed : nullptr},
      {owned.torque_limit.data(), owned.speed_limit.data()},
      owned.points.data(),
      static_cast<int>(owned.points.size())};
  const Robot& robot = vehicle.robot;
  const std::ptrdiff_t size = vehicle.commands(), states = vehicle.states();
  const auto dt = input<1>("dt", dt_, {ANY});
  const std::ptrdiff_t steps = dt.size(0);
  const auto command = input<3>("command", command_, {steps, 3, size});
  const auto start = input<1>("state", state_, {states});
  const auto wanted = input<1>("shown", shown_, {steps});
  const double* flags = wanted.data();
  Shown shown(robot, std::count_if(flags, flags + steps, [](double x) { return x != 0.0; }));
  Out<1> state(states);
  {
    nb::gil_scoped_release release;
    std::copy_n(start.data(), states, state.data());
    EquationsMemory<double> plant(robot), model(owned.computed ? computed.model : robot);
    Values room(static_cast<std::size_t>(3 * states + 2 * robot.speeds()));
    double *slope = room.data(), *stage = slope + states, *end = stage + states;
    FlightMemory memory{plant.eq, model.eq, end + states, end + states + robot.speeds()};
    std::ptrdiff_t row = 0;
    for (std::ptrdiff_t k = 0; k < steps; ++k) {
      const double* first = command.data() + 3 * size * k;
      const Command commands[3] = {{first, robot.tree.joints, robot.wheels},
                                   {first + size, robot.tree.joints, robot.wheels},
                                   {first + 2 * size, robot.tree.joints, robot.wheels}};
      flight_step(vehicle, dt.data()[k], commands, state.data(), slope, stage, end, memory, [&] {
        if (flags[k] != 0.0) shown.set(row++, robot, state.data(), memory);
      });
    }
  }
  return std::make_tuple(state.give(), shown.give());
}

}  // namespace

void bind_free_flying(nb::module_& m) {
  m.def(
      "forward_dynamics", &forward, nb::arg("robot"), nb::arg("q"), nb::arg("v"), nb::arg("Q"),
      nb::arg("vd"), nb::arg("free"), nb::arg("threads") = 1,
      "v' from H+ v' + c+ = Q where free is 1, as given where it is 0; and the acceleration of S.");
  nb::class_<OwnedComputedTorque>(m, "ComputedTorque", "Torques by a model.")
      .def(nb::new_(&make_computed), nb::arg("model"), nb::arg("of_momentum"), nb::arg("kp"),
           nb::arg("kd"));
  nb::class_<OwnedVehicle>(m, "Vehicle", "A robot, its control laws, and where wrenches act.")
      .def(nb::new_(&make_vehicle), nb::arg("robot"), nb::arg("free"), nb::arg("Kp"), nb::arg("Kd"),
           nb::arg("k"), nb::arg("speed"), nb::arg("share"), nb::arg("kp"), nb::arg("kd"),
           nb::arg("x_WD"), nb::arg("torque_limit"), nb::arg("speed_limit"), nb::arg("body"),
           nb::arg("point"), nb::arg("computed").none());
  m.def("fly", &fly, nb::arg("vehicle"), nb::arg("state"), nb::arg("dt"), nb::arg("command"),
        nb::arg("shown"), "RK4 steps from a state; what is seen at the start of the shown ones.");
}

}  // namespace orbident::python
