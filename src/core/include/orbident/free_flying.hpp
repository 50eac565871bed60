// Free flying: thrusters, wheels and joint torques move the robot (Eqs. 13, 15), by RK4 steps.
//
//   r_cm' = R_0 v_cm,   x_WB' = 1/2 x_WB (w, 0),   q' = qd,   q_rw' = qd_rw,   H+ v' + c+ = Q
//
// A joint that is not free accelerates as commanded; its torque is what that takes.
#pragma once

#include "orbident/control_laws.hpp"

namespace orbident {

// A robot and what drives it; views of constant tables.
struct Vehicle {
  Robot robot;
  const double* free;  // speeds: 0 of a driven joint, of a held wheel and out of the plane, else 1
  ControlLaws laws;
  WheelLimits limits;
  const BodyPoint* point;  // where the commanded wrenches act
  int wrenches;
  int states() const { return 7 + robot.tree.joints + robot.wheels + robot.speeds(); }
  int commands() const { return Command::size(robot.tree.joints, robot.wheels, wrenches); }
};

// The parts of a state, or of its derivative.
template <class Number>
struct Flying {
  Number *r_cm, *x_WB, *q, *q_rw, *v;
  Flying(const Robot& robot, Number* x)
      : r_cm(x), x_WB(x + 3), q(x + 7), q_rw(q + robot.tree.joints), v(q_rw + robot.wheels) {}
};

// Memory of the caller; what is seen in a state besides.
struct FlightMemory {
  EquationsOfMotion<double> plant;
  EquationsOfMotion<double> model;
  double* vd;   // speeds
  double* tau;  // joints and wheels
};

// The derivative of a state under the laws and the wrenches.
inline void rate(const Vehicle& vehicle, const double* state, const Command& command,
                 FlightMemory& memory, double* derivative) {
  const Robot& robot = vehicle.robot;
  const int joints = robot.tree.joints, wheels = robot.wheels, N = robot.speeds();
  const Flying<const double> x(robot, state);
  const Quaternion<double> x_WB(x.x_WB);
  const double* qd_rw = x.v + 6 + joints;
  control(vehicle.laws, robot, x.q, x_WB, x.v, command, memory.model, memory.tau);
  double* tau_rw = memory.tau + joints;
  for (int k = 0; k < wheels; ++k)
    tau_rw[k] = limited(tau_rw[k], qd_rw[k], vehicle.limits.torque[k], vehicle.limits.speed[k]);

  EquationsOfMotion<double>& eq = memory.plant;
  set_up(robot, x.q, x.v, eq);
  Column<double> Q(eq.Q, N);
  Q.head<6>().setZero();
  Q.tail(joints + wheels) = Column<double>(memory.tau, joints + wheels);
  for (int k = 0; k < vehicle.wrenches; ++k)
    add_wrench(robot, vehicle.point[k], Vector3<double>(command.wrench + 6 * k),
               Vector3<double>(command.wrench + 6 * k + 3), eq);
  Column<double> vd(memory.vd, N);
  vd.setZero();
  std::copy_n(command.qdd, joints, memory.vd + 6);
  for (int k = 0; k < joints; ++k)
    if (vehicle.free[6 + k] == 0.0) memory.tau[k] = eq.c[6 + k] - Q[6 + k];
  accelerate(robot, vehicle.free, eq, memory.vd);
  const Square<double> H(eq.H, N, N);
  for (int k = 0; k < joints; ++k)
    if (vehicle.free[6 + k] == 0.0) memory.tau[k] += H.row(6 + k).dot(vd);

  const Flying<double> slope(robot, derivative);
  Eigen::Map<Vector3<double>>(slope.r_cm) = quaternion_matrix(x_WB) * Vector3<double>(x.v);
  Eigen::Map<Quaternion<double>>(slope.x_WB) = quaternion_rate(x_WB, Vector3<double>(x.v + 3));
  std::copy_n(x.v + 6, joints, slope.q);
  std::copy_n(qd_rw, wheels, slope.q_rw);
  Column<double>(slope.v, N) = vd;
}

// One RK4 step: x goes on, and `slope` gets the derivative at its start. Of the three commands, the
// middle one holds at both middle stages; see() is called with what memory has at the start.
template <class See>
void flight_step(const Vehicle& vehicle, double dt, const Command (&commands)[3], double* state,
                 double* slope_room, double* stage_room, double* end_room, FlightMemory& memory,
                 See&& see) {
  const int n = vehicle.states();
  Column<double> x(state, n), slope(slope_room, n), stage(stage_room, n), end(end_room, n);
  end = x;
  const double along[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1 / 6.0, 2 / 6.0, 2 / 6.0, 1 / 6.0};
  const int node[] = {0, 1, 1, 2};
  for (int k = 0; k < 4; ++k) {
    stage = x;
    if (k > 0) stage += along[k] * dt * slope;
    rate(vehicle, stage.data(), commands[node[k]], memory, slope.data());
    if (k == 0) see();
    end += weight[k] * dt * slope;
  }
  x = end;
  Column<double> x_WB(Flying<double>(vehicle.robot, state).x_WB, 4);
  x_WB /= x_WB.norm();
}

}  // namespace orbident
