// The free-flying equations of motion, H+ v' + c+ = Q (Eqs. 8 to 14).
//
// Generalised speeds v = [v_cm, w, qd, qd_rw]: velocity of the system CM, base rate, joint rates
// and wheel speeds relative to the base; v_cm and w are inertial motions in base axes, and v' is
// the derivative of these components.
//
//   H+ = | M 1   0     0     0    |      c+ by Newton and Euler with v' = 0, forces and moments
//        | 0     D     D_q   A_rw |      about S; the system CM is at rest, and its own motion adds
//        | 0     D_q^T D_qq  0    |      only the force M w x v_cm.
//        | 0     A_rw^T 0    I_rw |
//
// A rotor of inertia J that turns N times as fast as joint k, about the same axis a, adds N J qd_k
// a to the momentum and 1/2 J (N qd_k)^2 + N J qd_k a . w to the energy, w the rate of the body
// that carries it. So has theta with N J a a^T more in the driven body and less in the carrying
// one, but for 1/2 N (N - 1) J qd_k^2: a constant on the diagonal of D_qq, and nothing in c+.
#pragma once

#include "orbident/inertia.hpp"

namespace orbident {

struct Wheel {
  Vector3<Real> axis;  // unit vector, base axes
  Real inertia;        // about its axis, kg m^2; counted in the base already
};

// What the equations of motion need of a robot; views of constant tables.
struct Robot {
  Tree tree;
  const Real* theta;     // bodies x 10
  const Real* armature;  // joints: what their motors' rotors add to D_qq beside theta, kg m^2
  const Wheel* wheel;
  int wheels;
  int speeds() const { return 6 + tree.joints + wheels; }
};

// Memory for one configuration; the caller's.
template <class T>
struct Bodies {
  Pose<T>* pose;          // bodies
  Motion<T>* field;       // joints
  Motion<T>* motion;      // bodies
  Motion<T>* rate;        // bodies
  Mass<T>* mass;          // bodies
  Mass<T>* carried;       // bodies
  Momentum<T>* momentum;  // joints
};

template <class T>
using Square = Eigen::Map<Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
template <class T>
using Column = Eigen::Map<Eigen::Matrix<T, Eigen::Dynamic, 1>>;

// What follows once the bodies are placed and weighed.
template <class T>
void finish(const Robot& robot, Bodies<T>& at) {
  carry(robot.tree, at.mass, at.carried);
  for (int k = 0; k < robot.tree.joints; ++k)
    at.momentum[k] = momentum_of(at.carried[k + 1], at.field[k]);
}

template <class T>
void configure(const Robot& robot, const T* q, Bodies<T>& at) {
  place(robot.tree, q, at.pose, at.field);
  weigh(robot.tree, robot.theta, at.pose, at.mass);
  finish(robot, at);
}

// D_qq at a configured state, with the rotors.
template <class T, class Matrix>
void joint_block(const Robot& robot, const Bodies<T>& at, Matrix&& D_qq) {
  joint_inertia(robot.tree, at.field, at.momentum, at.carried[0].m, D_qq);
  for (int k = 0; k < robot.tree.joints; ++k) D_qq(k, k) += T(robot.armature[k]);
}

// H+ at a configured state.
template <class T>
void mass_matrix(const Robot& robot, const Bodies<T>& at, Square<T> H) {
  const int joints = robot.tree.joints;
  const SystemInertia<T> all = system_inertia(at.carried[0]);
  H.setZero();
  H.template topLeftCorner<3, 3>().diagonal().setConstant(all.M);
  H.template block<3, 3>(3, 3) = all.D;
  for (int k = 0; k < joints; ++k) {
    const Vector3<T> D_q = at.momentum[k].h - all.r_cm.cross(at.momentum[k].p);
    H.template block<3, 1>(3, 6 + k) = D_q;
    H.template block<1, 3>(6 + k, 3) = D_q.transpose();
  }
  joint_block(robot, at, H.block(6, 6, joints, joints));
  for (int k = 0; k < robot.wheels; ++k) {
    const Vector3<T> A_rw = (robot.wheel[k].axis * robot.wheel[k].inertia).template cast<T>();
    H.template block<3, 1>(3, 6 + joints + k) = A_rw;
    H.template block<1, 3>(6 + joints + k, 3) = A_rw.transpose();
    H(6 + joints + k, 6 + joints + k) = T(robot.wheel[k].inertia);
  }
}

// c+ at a configured state; returns the acceleration of S where v' = 0, base axes.
template <class T>
Vector3<T> bias(const Robot& robot, const T* v, Bodies<T>& at, Column<T> c) {
  const Tree& tree = robot.tree;
  const Vector3<T> v_cm(v[0], v[1], v[2]), w(v[3], v[4], v[5]);
  const T *qd = v + 6, *qd_rw = qd + tree.joints;
  const T M = at.carried[0].m;
  move(tree, at.field, w, qd, at.motion);

  // Velocities with the system CM at rest, instead of S.
  Vector3<T> P = Vector3<T>::Zero();
  for (int i = 0; i < tree.bodies(); ++i)
    P += at.mass[i].m * at.motion[i].u + at.motion[i].w.cross(at.mass[i].s);
  for (int i = 0; i < tree.bodies(); ++i) at.motion[i].u -= P / M;

  // Accelerations where v' = 0: a field is fixed in the body its joint moves, S_k' = V_k x S_k.
  at.rate[0] = {Vector3<T>::Zero(), Vector3<T>::Zero()};
  for (int k = 0; k < tree.joints; ++k) {
    const Motion<T>&V = at.motion[k + 1], &S = at.field[k], &parent = at.rate[tree.joint[k].parent];
    at.rate[k + 1] = {parent.w + qd[k] * V.w.cross(S.w),
                      parent.u + qd[k] * (V.w.cross(S.u) + V.u.cross(S.w))};
  }

  // Force f and moment n about S of every body, in place of its acceleration.
  Vector3<T> h_rw = Vector3<T>::Zero();
  for (int k = 0; k < robot.wheels; ++k)
    h_rw += qd_rw[k] * (robot.wheel[k].axis * robot.wheel[k].inertia).template cast<T>();
  Vector3<T> F = Vector3<T>::Zero();
  for (int i = 0; i < tree.bodies(); ++i) {
    const Mass<T>& body = at.mass[i];
    const Motion<T>& V = at.motion[i];
    const Motion<T> a = at.rate[i];
    const Vector3<T> p = body.m * V.u + V.w.cross(body.s);
    Vector3<T> l = body.s.cross(V.u) + body.J * V.w;
    if (i == 0) l += h_rw;
    at.rate[i].u = body.m * a.u + a.w.cross(body.s) + V.w.cross(p);
    at.rate[i].w = body.s.cross(a.u) + body.J * a.w + V.w.cross(l) + V.u.cross(p);
    F += at.rate[i].u;
  }

  // The CM does not accelerate: all bodies share the acceleration a_0 = -F / M of S.
  const Vector3<T> a_0 = -F / M;
  for (int i = 0; i < tree.bodies(); ++i) {
    at.rate[i].u += at.mass[i].m * a_0;
    at.rate[i].w += at.mass[i].s.cross(a_0);
  }

  // A joint's torque is the power of what it carries, at unit rate.
  for (int k = tree.joints - 1; k >= 0; --k) {
    const Motion<T>& load = at.rate[k + 1];
    c[6 + k] = at.field[k].w.dot(load.w) + at.field[k].u.dot(load.u);
    at.rate[tree.joint[k].parent].w += load.w;
    at.rate[tree.joint[k].parent].u += load.u;
  }
  c.template segment<3>(0) = M * w.cross(v_cm);
  c.template segment<3>(3) = at.rate[0].w;
  c.tail(robot.wheels).setZero();
  return a_0 + w.cross(at.motion[0].u) + w.cross(v_cm);
}

}  // namespace orbident
