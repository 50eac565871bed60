// What each sensor of the base shows, and how that changes with the unknowns of an interval.
//
//   gyro            w + bias                                          (Eqs. 2, 3)
//   attitude        x_WB; its slopes are those of its small rotation, base axes
//   position        r_S = r_cm(t) - R_0 r_cm
//   velocity        v_S = v_cm(t) - R_0 u,  u = w x r_cm + J_cm qd    (Eqs. 27 to 30)
//   accelerometer   f_S = R_0^T felt - (u' + w x u) + bias
//
// with w' from h_B' = R_0^T torque - w x h_B. What pulls at all parts alike is not felt.
#pragma once

#include "orbident/shooting.hpp"

namespace orbident {

template <class T>
Vector3<T> velocity_in_base(const JointNode<T>& joints, const BaseNode<T>& base) {
  return base.w.cross(joints.terms.r_cm) + joints.terms.v_q;
}

template <class T>
Vector3<T> position(const JointNode<T>& joints, const BaseNode<T>& base, const T* outside) {
  const Contributions<T> parts = contributions(joints.t);
  return contributed(parts.r_cm, outside) + joints.acting.value(ON_R) -
         base.R_WB * joints.terms.r_cm;
}

template <class T>
Vector3<T> velocity(const JointNode<T>& joints, const BaseNode<T>& base, const T* outside) {
  const Contributions<T> parts = contributions(joints.t);
  return contributed(parts.v_cm, outside) + joints.acting.value(ON_V) -
         base.R_WB * velocity_in_base(joints, base);
}

// Without bias, base axes.
template <class T>
Vector3<T> specific_force(const JointNode<T>& joints, const BaseNode<T>& base) {
  const Vector3<T>& w = base.w;
  const Vector3<T> torque = joints.acting.value(ON_H_RATE);
  const Vector3<T> h_dot = base.R_WB.transpose() * torque - w.cross(base.h_B);
  const Vector3<T> w_dot =
      base.E * (h_dot - joints.rates.D * w - joints.rates.h_q - joints.h_rw_rate);
  // The rate of r_cm, base axes, is v_q.
  const Vector3<T> u_dot =
      w_dot.cross(joints.terms.r_cm) + w.cross(joints.terms.v_q) + joints.rates.v_q;
  return base.R_WB.transpose() * joints.acting.value(ON_FELT) -
         (u_dot + w.cross(velocity_in_base(joints, base)));
}

template <class T>
void add_outside(const IntervalColumns& columns, const T* parts, TableRows<T, 3>& slopes) {
  for (int k = 0; k < CONSERVED; ++k)
    slopes.template middleCols<3>(columns.outside() + 3 * k).diagonal().array() += parts[k];
}

template <class T>
void position_slopes(const IntervalColumns& columns, const JointNode<T>& joints,
                     const BaseNode<T>& base, T* out) {
  const int n = columns.count();
  TableRows<T, 3> slopes(out, 3, n);
  const Matrix3<T>& R = base.R_WB;
  slopes =
      (R * cross_matrix(joints.terms.r_cm)).eval().lazyProduct(TableRows<T, 3>(base.phi, 3, n)) -
      R.lazyProduct(TableRows<T, 3>(joints.by + BY_R * n, 3, n));
  add_outside(columns, contributions(joints.t).r_cm, slopes);
  joints.acting.add(ON_R, Matrix3<T>::Identity(), slopes);
}

// Relative to the CM, inertial axes.
template <class T>
void velocity_slopes(const IntervalColumns& columns, const JointNode<T>& joints,
                     const BaseNode<T>& base, T* out) {
  const int n = columns.count();
  const Matrix3<T>& R = base.R_WB;
  const Matrix3<T> by_r = -R * cross_matrix(base.w), by_w = R * cross_matrix(joints.terms.r_cm),
                   by_phi = R * cross_matrix(velocity_in_base(joints, base));
  TableRows<T, 3>(out, 3, n) = by_r.lazyProduct(TableRows<T, 3>(joints.by + BY_R * n, 3, n)) -
                               R.lazyProduct(TableRows<T, 3>(joints.by + BY_V * n, 3, n)) +
                               by_w.lazyProduct(TableRows<T, 3>(base.dw, 3, n)) +
                               by_phi.lazyProduct(TableRows<T, 3>(base.phi, 3, n));
}

// The slopes of the specific force are R_0^T (R_0^T dv_S)' + [f_S]x phi: the rate by the parabola
// through the slopes of the velocity at a row, half-way and at the next row, dt later.
template <class T>
void add_rate_of_velocity(const IntervalColumns& columns, const Matrix3<T>& R_WB, const T& dt,
                          const T* row, const T* half_way, const T* next, T* out) {
  const int n = columns.count();
  const Matrix3<T> per_time = R_WB.transpose() / dt;
  const ConstTableRows<T, 3> v_0(row, 3, n), v_1(half_way, 3, n), v_2(next, 3, n);
  TableRows<T, 3>(out, 3, n) += per_time.lazyProduct(4 * v_1 - 3 * v_0 - v_2);
}

}  // namespace orbident
