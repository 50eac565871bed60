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

inline Vector3<double> velocity_in_base(const JointNode& joints, const BaseNode& base) {
  return base.w.cross(joints.terms.r_cm) + joints.terms.v_q;
}

inline Vector3<double> position(const JointNode& joints, const BaseNode& base,
                                const double* outside) {
  const Contributions parts = contributions(joints.t);
  return contributed(parts.r_cm, outside) + joints.acting.value(ON_R) -
         base.R_WB * joints.terms.r_cm;
}

inline Vector3<double> velocity(const JointNode& joints, const BaseNode& base,
                                const double* outside) {
  const Contributions parts = contributions(joints.t);
  return contributed(parts.v_cm, outside) + joints.acting.value(ON_V) -
         base.R_WB * velocity_in_base(joints, base);
}

// Without bias, base axes.
inline Vector3<double> specific_force(const JointNode& joints, const BaseNode& base) {
  const Vector3<double>& w = base.w;
  const Vector3<double> torque = joints.acting.value(ON_H_RATE);
  const Vector3<double> h_dot = base.R_WB.transpose() * torque - w.cross(base.h_B);
  const Vector3<double> w_dot =
      base.E * (h_dot - joints.rates.D * w - joints.rates.h_q - joints.h_rw_rate);
  // The rate of r_cm, base axes, is v_q.
  const Vector3<double> u_dot =
      w_dot.cross(joints.terms.r_cm) + w.cross(joints.terms.v_q) + joints.rates.v_q;
  return base.R_WB.transpose() * joints.acting.value(ON_FELT) -
         (u_dot + w.cross(velocity_in_base(joints, base)));
}

inline void add_outside(const IntervalColumns& columns, const double* parts, TableRows& slopes) {
  for (int k = 0; k < CONSERVED; ++k)
    slopes.middleCols<3>(columns.outside() + 3 * k).diagonal().array() += parts[k];
}

inline void position_slopes(const IntervalColumns& columns, const JointNode& joints,
                            const BaseNode& base, double* out) {
  const int n = columns.count();
  TableRows slopes(out, 3, n);
  const Matrix3<double>& R = base.R_WB;
  CombinedRows(out, n)
      .zero()
      .add(R * cross_matrix(joints.terms.r_cm), base.phi)
      .add(-R, joints.by + BY_R * n);
  add_outside(columns, contributions(joints.t).r_cm, slopes);
  joints.acting.add(ON_R, Matrix3<double>::Identity(), slopes);
}

// Relative to the CM, inertial axes.
inline void velocity_slopes(const IntervalColumns& columns, const JointNode& joints,
                            const BaseNode& base, double* out) {
  const int n = columns.count();
  const Matrix3<double>& R = base.R_WB;
  const Matrix3<double> by_r = -R * cross_matrix(base.w),
                        by_w = R * cross_matrix(joints.terms.r_cm),
                        by_phi = R * cross_matrix(velocity_in_base(joints, base));
  CombinedRows(out, n)
      .zero()
      .add(by_r, joints.by + BY_R * n)
      .add(-R, joints.by + BY_V * n)
      .add(by_w, base.dw)
      .add(by_phi, base.phi);
}

// Adds `by` times the rate of the velocity's slopes, by the parabola through those at a row,
// half-way and at the next row, dt later: the slopes of the specific force are
// R_0^T (R_0^T dv_S)' + [f_S]x phi.
inline void add_rate_of_velocity(const IntervalColumns& columns, const Matrix3<double>& by,
                                 double dt, const double* row, const double* half_way,
                                 const double* next, double* out) {
  const int n = columns.count();
  const Matrix3<double> per_time = by / dt;
  CombinedRows(out, n).add(4 * per_time, half_way).add(-3 * per_time, row).add(-per_time, next);
}

}  // namespace orbident
