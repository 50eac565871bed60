// Control laws as data: the torques of joints and wheels in one state.
//
//   tau    = Kp (q_d - q) + Kd (qd_d - qd) + tau_d                              joints
//   tau_rw = k (qd_rw,d - qd_rw) + share (kp e + kd w) + tau_rw,d               rotors
//
// with e twice the vector part of the quaternion from the attitude to hold, and `share` the wheels'
// parts in a moment: a rotor driven by tau_rw turns the base by -a tau_rw. A law that is not used
// has zero gains.
//
// Computed torque adds what a model needs for y'' = y_d'' + kd e' + kp e, where y are the joints
// and the attitude of the base: the wheels' accelerations are those that this takes (Eq. 10), and
// the system CM is left alone.
#pragma once

#include "orbident/forward_dynamics.hpp"

namespace orbident {

struct ComputedTorque {
  Robot model;
  const double* of_momentum;  // wheels x 3: the wheels' speeds for a momentum of theirs
  double kp;                  // 1/s^2
  double kd;                  // 1/s
};

struct ControlLaws {
  const double *Kp, *Kd;           // joints
  const double *k, *speed;         // wheels
  const double* share;             // wheels x 3
  double kp, kd;                   // N m/rad, N m s/rad
  Quaternion<double> x_WD;         // attitude to hold
  const ComputedTorque* computed;  // may be null
};

// The greatest torques and speeds of the wheels' motors; infinite where there is no limit.
struct WheelLimits {
  const double *torque, *speed;
};

// What a vehicle is commanded at one time: a row of joints [q, qd, qdd, tau], wheels [tau_rw],
// base attitude [x, w, w'] (its rates in its own axes) and wrenches [F, n] (base axes).
struct Command {
  const double *q, *qd, *qdd, *tau, *tau_rw, *x_WD, *w_D, *wd_D, *wrench;
  Command(const double* row, int joints, int wheels)
      : q(row),
        qd(q + joints),
        qdd(qd + joints),
        tau(qdd + joints),
        tau_rw(tau + joints),
        x_WD(tau_rw + wheels),
        w_D(x_WD + 4),
        wd_D(w_D + 3),
        wrench(wd_D + 3) {}
  static int size(int joints, int wheels, int wrenches) {
    return 4 * joints + wheels + 10 + 6 * wrenches;
  }
};

// Over this last part of its top speed a motor's torque falls to zero.
constexpr double TAPER = 0.02;

// At most the greatest torque, and none that drives a wheel beyond its top speed.
inline double limited(double tau, double qd_rw, double most_torque, double top_speed) {
  tau = std::min(std::max(tau, -most_torque), most_torque);
  const double sign = tau > 0 ? 1.0 : (tau < 0 ? -1.0 : 0.0);
  const double left = (1.0 - sign * qd_rw / top_speed) / TAPER;
  return tau * std::min(std::max(left, 0.0), 1.0);
}

// Adds the torques of joints and wheels to tau; eq is memory for the model.
inline void add_computed_torque(const ComputedTorque& law, const double* q,
                                const Quaternion<double>& x_WB, const double* v,
                                const Command& command, EquationsOfMotion<double>& eq,
                                double* tau) {
  const Robot& model = law.model;
  const int joints = model.tree.joints, N = model.speeds();
  set_up(model, q, v, eq);
  Column<double> vd(eq.Q, N);
  vd.setZero();

  const Quaternion<double> x_WD(command.x_WD);
  const Matrix3<double> R_DB = quaternion_matrix(x_WD).transpose() * quaternion_matrix(x_WB);
  // R_DB = 1 + [e]x to first order.
  const Vector3<double> e(0.5 * (R_DB(2, 1) - R_DB(1, 2)), 0.5 * (R_DB(0, 2) - R_DB(2, 0)),
                          0.5 * (R_DB(1, 0) - R_DB(0, 1)));
  const Vector3<double> w(v + 3);
  const Vector3<double> w_d = R_DB.transpose() * Vector3<double>(command.w_D);
  const Vector3<double> wd_d = R_DB.transpose() * Vector3<double>(command.wd_D) - w.cross(w_d);
  vd.segment<3>(3) = wd_d + law.kd * (w_d - w) - law.kp * e;
  for (int k = 0; k < joints; ++k)
    vd[6 + k] =
        command.qdd[k] + law.kd * (command.qd[k] - v[6 + k]) + law.kp * (command.q[k] - q[k]);

  const Square<double> H(eq.H, N, N);
  const Column<double> c(eq.c, N);
  const Vector3<double> left = H.middleRows<3>(3) * vd + c.segment<3>(3);
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>> of_momentum(
      law.of_momentum, model.wheels, 3);
  vd.tail(model.wheels) = -of_momentum * left;
  for (int i = 6; i < N; ++i) tau[i - 6] += H.row(i).dot(vd) + c[i];
}

// The torques of joints and wheels, before the limits of the wheels' motors.
inline void control(const ControlLaws& laws, const Robot& robot, const double* q,
                    const Quaternion<double>& x_WB, const double* v, const Command& command,
                    EquationsOfMotion<double>& model, double* tau) {
  const int joints = robot.tree.joints;
  const double *qd = v + 6, *qd_rw = qd + joints;
  for (int k = 0; k < joints; ++k)
    tau[k] =
        laws.Kp[k] * (command.q[k] - q[k]) + laws.Kd[k] * (command.qd[k] - qd[k]) + command.tau[k];
  const Vector3<double> turn =
      laws.kp * small_rotation(laws.x_WD, x_WB) + laws.kd * Vector3<double>(v + 3);
  for (int k = 0; k < robot.wheels; ++k)
    tau[joints + k] = laws.k[k] * (laws.speed[k] - qd_rw[k]) +
                      turn.dot(Vector3<double>(laws.share + 3 * k)) + command.tau_rw[k];
  if (laws.computed) add_computed_torque(*laws.computed, q, x_WB, v, command, model, tau);
}

}  // namespace orbident
