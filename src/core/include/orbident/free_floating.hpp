// Free floating (Eqs. 2, 3, 17, 18): the momentum h_cm about the system CM determines the base
// rate,
//
//   D w + D_q qd + A_rw qd_rw = R_0^T h_cm   =>   w = E R_0^T h_cm - b,
//
// with E and b known from the joints alone; only the quaternion is integrated. The velocity of the
// feature point S and its position relative to the CM are
//
//   R_0^T (v_S - v_cm) = -(w x r_cm + J_cm qd),   R_0^T (r_S - r_CM) = -r_cm.
//
// h_cm may change with time: it is given wherever the law is.
#pragma once

#include <Eigen/LU>

#include "orbident/inertia.hpp"

namespace orbident {

// What momentum needs of the joint states, base axes.
template <class T>
struct FloatingTerms {
  Matrix3<T> D;
  Vector3<T> h_q;   // D_q qd
  Vector3<T> r_cm;  // from S to the system CM, m
  Vector3<T> v_q;   // J_cm qd
};

// From the momenta of all bodies at the joint rates, with the base at rest.
template <class T>
FloatingTerms<T> floating_terms(const Tree& tree, const double* theta, const T* q, const T* qd,
                                Pose<T>* pose, Motion<T>* field, Motion<T>* motion, Mass<T>* mass) {
  place(tree, q, pose, field);
  weigh(tree, theta, pose, mass);
  move(tree, field, Vector3<T>(Vector3<T>::Zero()), qd, motion);
  Mass<T> all = mass[0];
  Vector3<T> P = Vector3<T>::Zero(), A = Vector3<T>::Zero();
  for (int i = 1; i < tree.bodies(); ++i) {
    all.m += mass[i].m;
    all.s += mass[i].s;
    all.J += mass[i].J;
    P += mass[i].m * motion[i].u + motion[i].w.cross(mass[i].s);
    A += mass[i].s.cross(motion[i].u) + mass[i].J * motion[i].w;
  }
  const SystemInertia<T> system = system_inertia(all);
  return {system.D, A - system.r_cm.cross(P), system.r_cm, P / all.m};
}

// w = E R_0^T h_cm - b, base axes.
template <class T>
struct RateLaw {
  Matrix3<T> E;
  Vector3<T> b;
  Vector3<T> rate(const Quaternion<T>& x_WB, const Vector3<T>& h_cm) const {
    return E * rotate_back(x_WB, h_cm) - b;
  }
};

// From D w + h_moving = R_0^T h_cm; in the plane from its z row alone.
template <class T>
RateLaw<T> rate_law(const Matrix3<T>& D, const Vector3<T>& h_moving, bool planar) {
  Matrix3<T> E = Matrix3<T>::Zero();
  if (planar)
    E(2, 2) = T(1) / D(2, 2);
  else
    E = D.inverse();
  return {E, E * h_moving};
}

// The law and the momentum at one time; h_cm in inertial axes.
template <class T>
struct FloatingNode {
  RateLaw<T> law;
  Vector3<T> h_cm;
  Quaternion<T> rate(const Quaternion<T>& x_WB) const {
    return quaternion_rate(x_WB, law.rate(x_WB, h_cm));
  }
};

// One RK4 step of the attitude, over the nodes at its start, its middle and its end.
template <class T>
Quaternion<T> attitude_step(const Quaternion<T>& x_WB, const T& dt, const FloatingNode<T>& start,
                            const FloatingNode<T>& middle, const FloatingNode<T>& end) {
  const Quaternion<T> k_1 = start.rate(x_WB);
  const Quaternion<T> k_2 = middle.rate(x_WB + dt / T(2) * k_1);
  const Quaternion<T> k_3 = middle.rate(x_WB + dt / T(2) * k_2);
  const Quaternion<T> k_4 = end.rate(x_WB + dt * k_3);
  const Quaternion<T> x = x_WB + dt / T(6) * (k_1 + T(2) * k_2 + T(2) * k_3 + k_4);
  return x / x.norm();
}

}  // namespace orbident
