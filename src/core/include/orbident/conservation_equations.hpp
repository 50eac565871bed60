// Both conservation laws of one sample, linear in all unknowns, and the noise of these equations.
//
// In base axes, with the rate w = w_gyro - b_g - n,
//
//   Y pi - R_0^T h_cm - D b_g = -A_rw qd_rw + R_0^T h_given     (Eqs. 2, 19)
//   W phi + R_0^T v_cm + U b_g = R_0^T v_S                      (Eq. 29)
//
// with what thrusters and the like have given to the momentum, h_given, D = d h_rs / dw and
// U = d (velocity of the CM relative to S) / dw = -[r_cm]x at the parameters
// known so far. The gyro's noise n adds D n and -U n on the right; the noise of attitude and joint
// rates adds to that.
//
// Y and W are evaluated at a smoothed rate, and D, U take them to the gyro's: noise in a regressor
// is mistaken for excitation, and while the base hardly changes its rate, least squares would
// conclude that it has no inertia.
#pragma once

#include "orbident/equations_of_motion.hpp"
#include "orbident/regressors.hpp"

namespace orbident {

using Vector = Vector3<Real>;
using Matrix = Matrix3<Real>;

// Standard deviations, SI; white ones are those of a sample.
struct SensorNoise {
  Real gyro;           // white, rad/s
  Real velocity;       // white, m/s
  Real gyro_bias;      // beforehand, rad/s
  Real gyro_walk;      // of the bias, rad/s/sqrt(s)
  Real integrated;     // 1 where the attitude is the integrated gyro and drifts with it, else 0
  Real attitude;       // white, rad
  Real velocity_walk;  // of v_cm, or of a velocity integrated from an accelerometer, m/s/sqrt(s)
  Real accelerometer_bias;  // beforehand, m/s^2
  Real accelerometer_walk;  // of the bias, m/s^2/sqrt(s)
  Real joint_rates;         // white, rad/s or m/s
  Real momentum_walk;       // of h_cm, N m s/sqrt(s)
  bool accelerometer;       // whether the velocity is integrated, and the bias an unknown
};

// The base axes in which angular and linear momentum are conserved.
struct ConservedAxes {
  int momentum[3];
  int momenta;
  int velocity[3];
  int velocities;
  constexpr int all() const { return momenta + velocities; }
};

// What a joint's torque drives beside the joint's momentum: the rotor's energy beyond that of
// bodies (kg m^2), viscous and Coulomb friction, an offset of the torque, and its error in scale.
enum Drive { armature, viscous, coulomb, offset, scale, DRIVES };

// A joint whose torque is measured.
struct DrivenJoint {
  int joint;
  Real walk;           // what the torque's noise adds to the momentum, N m s/sqrt(s)
  Real still;          // slower the joint may stand, held by what no equation has, rad/s
  Real known[DRIVES];  // beforehand; SI
  Real std[DRIVES];    // and how surely
};

struct DrivenJoints {
  const DrivenJoint* each;
  int count;
  Real longest;  // s from sample to sample over which a torque can be followed
};

// What the laws need of a robot; views of constant tables. The robot's own theta is not used.
struct ConservationModel {
  Robot robot;
  MinimalSets sets;
  Sparse theta_of;  // theta x beta
  ConservedAxes axes;
  SensorNoise noise;
  DrivenJoints driven;
  // Nuisances x = [h_cm, v_cm, p, b_g, b_a, drives], with the momenta p of driven joints and what
  // each of them drives, and linear parameters y = [pi, phi].
  constexpr int joint_momentum() const { return axes.all(); }
  constexpr int gyro_bias() const { return joint_momentum() + driven.count; }
  constexpr int accelerometer_bias() const { return gyro_bias() + axes.momenta; }
  constexpr int drives() const {
    return accelerometer_bias() + (noise.accelerometer ? axes.velocities : 0);
  }
  constexpr int nuisances() const { return drives() + DRIVES * driven.count; }
  constexpr int parameters() const { return sets.pis() + sets.phis(); }
};

// What was measured at one time; NaN where nothing was.
struct Measurement {
  const Real* q;
  const Real* qd;
  const Real* w;  // gyro, base axes, rad/s
  const Real* x_WB;
  const Real* qd_rw;
  const Real* v_S;       // inertial axes, m/s
  const Real* w_smooth;  // the rate with less noise
  const Real* h_given;   // angular momentum that acted from outside so far, inertial axes, N m s
  const Real* impulse;   // of each driven joint: its torque's integral so far, N m s
};

constexpr int measurement_size(int joints, int wheels, int driven) {
  return 2 * joints + wheels + 16 + driven;
}

inline Measurement measurement_at(const Robot& robot, const Real* packed) {
  const int n = robot.tree.joints;
  const Real* const w = packed + 2 * n;
  const Real* const v_S = w + 7 + robot.wheels;
  return {packed, packed + n, w, w + 3, w + 7, v_S, v_S + 3, v_S + 6, v_S + 9};
}

inline Vector given_momentum(const Measurement& at) {
  return Vector(at.h_given[0], at.h_given[1], at.h_given[2]);
}

// What the gyro's rate has beside the smoothed one.
inline Vector rate_excess(const ConservedAxes& axes, const Measurement& at) {
  Vector excess = Vector::Zero();
  for (int k = 0; k < axes.momenta; ++k)
    excess[axes.momentum[k]] = at.w[axes.momentum[k]] - at.w_smooth[axes.momentum[k]];
  return excess;
}

// Memory for the rows of one sample; the caller's.
struct EquationMemory {
  Bodies<Real> bodies;
  Real* theta;     // bodies x 10
  Real* columns;   // S, P and A: 3 x 3 x theta; zero before the first sample
  Real* sigma;     // 3 x phi
  Real* Y;         // 3 x pi
  Real* W;         // 3 x phi
  Real* load;      // bodies x 6: [p, h] of each with all that it carries, about S
  Real* by_joint;  // 3 x phi: how P_sigma changes with a joint
};

// Places and weighs the bodies of beta; D follows from what all of them weigh.
inline void configure_beta(const ConservationModel& model, const Real* beta, const Real* q,
                           EquationMemory& memory) {
  Robot robot = model.robot;
  robot.theta = memory.theta;
  for (int k = 0; k < PER_BODY * robot.tree.bodies(); ++k) memory.theta[k] = 0.0;
  for (int c = 0; c < model.theta_of.columns; ++c)
    for (int k = model.theta_of.first[c]; k < model.theta_of.first[c + 1]; ++k)
      memory.theta[model.theta_of.row[k]] += model.theta_of.value[k] * beta[c];
  configure(robot, q, memory.bodies);
}

inline Vector wheel_momentum(const Robot& robot, const Real* qd_rw) {
  Vector h_rw = Vector::Zero();
  for (int k = 0; k < robot.wheels; ++k)
    h_rw += qd_rw[k] * (robot.wheel[k].axis * robot.wheel[k].inertia);
  return h_rw;
}

// The noise of one law's rows, in base axes.
struct LawNoise {
  Matrix of_gyro;    // what noise of unit variance on each conserved axis of the gyro adds
  Matrix of_others;  // covariance of what all else adds
};

struct EquationNoise {
  LawNoise momentum;
  LawNoise velocity;
};

// The gyro's noise times [D; -U]. The others: the joint rates' times D_q and J_cm, a turn of the
// attitude, which turns R_0^T h, h = h_cm + h_given, and the velocity's own.
inline EquationNoise equation_noise(const ConservationModel& model, const Bodies<Real>& at,
                                    const SystemInertia<Real>& all, const Matrix& U,
                                    const Matrix& R_WB, const Vector& h) {
  const SensorNoise& noise = model.noise;
  const Matrix turn = noise.attitude * (R_WB.transpose() * cross_matrix(h));
  EquationNoise of{{Matrix::Zero(), turn * turn.transpose()},
                   {Matrix::Zero(), noise.velocity * noise.velocity * Matrix::Identity()}};
  for (int k = 0; k < model.axes.momenta; ++k) {
    const int axis = model.axes.momentum[k];
    of.momentum.of_gyro.col(k) = noise.gyro * all.D.col(axis);
    of.velocity.of_gyro.col(k) = -noise.gyro * U.col(axis);
  }
  for (int k = 0; k < model.robot.tree.joints; ++k) {
    const Vector D_q = noise.joint_rates * (at.momentum[k].h - all.r_cm.cross(at.momentum[k].p));
    const Vector J_cm = (noise.joint_rates / all.M) * at.momentum[k].p;
    of.momentum.of_others += D_q * D_q.transpose();
    of.velocity.of_others += J_cm * J_cm.transpose();
  }
  return of;
}

// The rows [x, pi, phi | right-hand side], momentum first; the velocity's are
// zero where v_S was not measured. D, U and the noise's gains are evaluated at beta and h. Returns
// the noise of these rows, which are not yet whitened.
inline EquationNoise conservation_equations(const ConservationModel& model, const Real* beta,
                                            const Vector& h, const Measurement& at,
                                            const Matrix& R_WB, EquationMemory& memory, Real* rows,
                                            int stride) {
  const Tree& tree = model.robot.tree;
  const ConservedAxes& axes = model.axes;
  Bodies<Real>& bodies = memory.bodies;
  configure_beta(model, beta, at.q, memory);
  const SystemInertia<Real> all = system_inertia(bodies.carried[0]);
  const Matrix U = -cross_matrix(all.r_cm);

  // In the plane the other two rates stay what was measured: zero.
  const Vector excess = rate_excess(axes, at);
  Vector w(at.w[0], at.w[1], at.w[2]);
  for (int k = 0; k < axes.momenta; ++k) w[axes.momentum[k]] = at.w_smooth[axes.momentum[k]];
  const int thetas = PER_BODY * tree.bodies(), pis = model.sets.pis(), phis = model.sets.phis();
  const Rows3<Real> S(memory.columns, 3, thetas), P(memory.columns + 3 * thetas, 3, thetas),
      A(memory.columns + 6 * thetas, 3, thetas);
  const Rows3<Real> Y(memory.Y, 3, pis), W(memory.W, 3, phis);
  move(tree, bodies.field, w, at.qd, bodies.motion);
  first_moment_columns(tree, bodies.pose, S);
  momentum_columns(tree, bodies.pose, bodies.motion, P, A);
  regressors(model.sets, S, P, A, Rows3<Real>(memory.sigma, 3, phis), Y, W);

  const int n = model.nuisances(), rhs = n + pis + phis;
  for (int k = 0; k < axes.all() * stride; ++k) rows[k] = 0.0;
  Vector known = R_WB.transpose() * given_momentum(at);
  known -= wheel_momentum(model.robot, at.qd_rw) + all.D * excess;
  for (int i = 0; i < axes.momenta; ++i) {
    const int axis = axes.momentum[i];
    Real* const row = rows + i * stride;
    for (int j = 0; j < axes.momenta; ++j) {
      row[j] = -R_WB(axes.momentum[j], axis);
      row[model.gyro_bias() + j] = -all.D(axis, axes.momentum[j]);
    }
    for (int k = 0; k < pis; ++k) row[n + k] = Y(axis, k);
    row[rhs] = known[axis];
  }
  Real* const moving = rows + axes.momenta * stride;
  const Vector v_S(at.v_S[0], at.v_S[1], at.v_S[2]);
  if (v_S.allFinite()) {
    const Vector told = R_WB.transpose() * v_S + U * excess;
    for (int i = 0; i < axes.velocities; ++i) {
      const int axis = axes.velocity[i];
      Real* const row = moving + i * stride;
      for (int j = 0; j < axes.velocities; ++j)
        row[axes.momenta + j] = R_WB(axes.velocity[j], axis);
      for (int j = 0; j < axes.momenta; ++j) row[model.gyro_bias() + j] = U(axis, axes.momentum[j]);
      for (int k = 0; k < phis; ++k) row[n + pis + k] = W(axis, k);
      row[rhs] = told[axis];
    }
  }
  return equation_noise(model, bodies, all, U, R_WB, h);
}

}  // namespace orbident
