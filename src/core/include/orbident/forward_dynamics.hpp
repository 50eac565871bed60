// From forces to accelerations (Eqs. 13, 15), where some accelerations may be known instead:
//
//   H+ v' + c+ = Q,   Q = [0, 0, tau, tau_rw] + sum_k J_k^T (F_k, n_k).
//
// A force F and a moment n on a body at its point p (from S, base axes) are over [v_cm, w, qd]
//
//   F,   n + (p - r_cm) x F,   w_j . (n + p x F) + (u_j - J_cm,j) . F,
//
// the first part of the last only for the joints that carry the body. So momentum obeys
// dh/dt = R_0 sum (n + (p - r_cm) x F) and M dv_cm/dt = R_0 sum F.
#pragma once

#include <Eigen/Cholesky>

#include "orbident/equations_of_motion.hpp"

namespace orbident {

// A point of a body, in the body's frame, m.
struct BodyPoint {
  int body;
  Vector3<double> p;
};

// The equations of motion in one state; memory of the caller.
template <class T>
struct EquationsOfMotion {
  Bodies<T> at;
  T* H;            // speeds x speeds
  T* factor;       // the same size: of the Cholesky factor
  T* c;            // speeds
  T* Q;            // speeds
  Vector3<T> f_S;  // acceleration of S where v' = 0, base axes
};

template <class T>
void set_up(const Robot& robot, const T* q, const T* v, EquationsOfMotion<T>& eq) {
  const int N = robot.speeds();
  configure(robot, q, eq.at);
  mass_matrix(robot, eq.at, Square<T>(eq.H, N, N));
  eq.f_S = bias(robot, v, eq.at, Column<T>(eq.c, N));
}

// Adds J^T (F, n) to the generalised forces of a configured state.
template <class T>
void add_wrench(const Robot& robot, const BodyPoint& point, const Vector3<T>& F,
                const Vector3<T>& n, EquationsOfMotion<T>& eq) {
  const Bodies<T>& at = eq.at;
  const T M = at.carried[0].m;
  const Vector3<T> p = at.pose[point.body].d + at.pose[point.body].R * point.p.template cast<T>();
  const Vector3<T> moment = n + p.cross(F);
  Column<T> Q(eq.Q, robot.speeds());
  Q.template segment<3>(0) += F;
  Q.template segment<3>(3) += moment - at.carried[0].s.cross(F) / M;
  for (int k = 0; k < robot.tree.joints; ++k) Q[6 + k] -= at.momentum[k].p.dot(F) / M;
  for (int k = point.body - 1; k >= 0; k = robot.tree.joint[k].parent - 1)
    Q[6 + k] += at.field[k].w.dot(moment) + at.field[k].u.dot(F);
}

// The linear part of J_0,S v (Eqs. 27, 28): v_S = v_cm - w x r_cm - J_cm qd. Of v', it is what the
// acceleration of S has beyond f_S.
template <class T>
Vector3<T> at_S(const Robot& robot, const Bodies<T>& at, const T* v) {
  const T M = at.carried[0].m;
  const Vector3<T> w(v[3], v[4], v[5]);
  Vector3<T> sum = Vector3<T>(v[0], v[1], v[2]) - w.cross(at.carried[0].s) / M;
  for (int k = 0; k < robot.tree.joints; ++k) sum -= at.momentum[k].p * (v[6 + k] / M);
  return sum;
}

// v' where some of it is known (free = 0) and elsewhere the force Q is (free = 1). vd has what is
// known, and gets the rest.
template <class T>
void accelerate(const Robot& robot, const double* free, EquationsOfMotion<T>& eq, T* vd) {
  const int N = robot.speeds();
  const Square<T> H(eq.H, N, N);
  Square<T> factor(eq.factor, N, N);
  Column<T> a(vd, N), Q(eq.Q, N);
  for (int i = 0; i < N; ++i)
    if (free[i] != 0.0) a[i] = T(0);
  Q -= Column<T>(eq.c, N);
  Q.noalias() -= H * a;
  // What is known has the rows and columns of the identity.
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j)
      factor(i, j) = free[i] * free[j] != 0.0 ? H(i, j) : T(i == j ? 1 : 0);
    if (free[i] == 0.0) Q[i] = T(0);
  }
  const Eigen::LLT<Eigen::Ref<Eigen::Matrix<T, -1, -1, Eigen::RowMajor>>> llt(factor);
  llt.solveInPlace(Q);
  a += Q;
}

}  // namespace orbident
