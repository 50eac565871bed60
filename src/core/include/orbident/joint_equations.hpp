// The own equations (Eq. 11) of joints that nobody measures, in momentum form: no accelerations.
//
//   p_k = S_k . h_k        dp_k/dt = S_k' . h_k + tau_k        S_k' = V_k x S_k
//
// with S_k the field of joint k, h_k the momentum of all that it carries, with the system CM at
// rest, and V_k the motion of the body that carries the joint (p_k = dT/dqd_k, S_k' . h_k =
// dT/dq_k). A spring and a damper hold it,
//
//   tau_k = -(1 + x)^2 r^2 I q - (1 + y) d I qd
//
// where x and y are unknowns, and I is the inertia of all that the joint carries, about its axis,
// linear in theta: with a stiffness in place of the rate r at which it swings, the likelihood would
// have a curved valley. Over an interval of length T, with s from -1 to 1 and F = S_k' . h_k +
// tau_k, a white torque leaves two independent sums,
//
//   p(T) - p(0) - int F dt = e_0,                       var e_0 = density^2 T
//   p(T) + p(0) - 2/T int p dt - int s F dt = e_1,      var e_1 = density^2 T / 3
//
// its integrals over the first two Legendre polynomials. The joint's cubic has two unknowns a
// boundary, and so these two equations an interval: a collocation of fourth order where the density
// is small.
#pragma once

#include "orbident/calibration.hpp"
#include "orbident/jet.hpp"

namespace orbident {

struct JointEquation {
  int joint;
  double square;          // r^2, rad^2/s^2
  double damping;         // d, 1/s
  double density;         // of the torque that is not explained, N m/sqrt(Hz) or N/sqrt(Hz)
  const double* carried;  // I by each entry of theta
};

// p_k and dT/dq_k of all joints.
template <class T>
void joint_momenta(const Tree& tree, const T* theta, const T* q, const T* qd, const Vector3<T>& w,
                   Bodies<T>& at, T* p, T* by_q) {
  place(tree, q, at.pose, at.field);
  weigh(tree, theta, at.pose, at.mass);
  move(tree, at.field, w, qd, at.motion);
  Vector3<T> P = Vector3<T>::Zero();
  T M = T(0.0);
  for (int i = 0; i < tree.bodies(); ++i) {
    P += momentum_of(at.mass[i], at.motion[i]).p;
    M += at.mass[i].m;
  }
  const Vector3<T> v_cm = P / M;
  for (int i = 0; i < tree.bodies(); ++i) {
    at.motion[i].u -= v_cm;
    at.momentum[i] = momentum_of(at.mass[i], at.motion[i]);
  }
  for (int k = tree.joints - 1; k >= 0; --k) {
    const int parent = tree.joint[k].parent;
    const Motion<T>&S = at.field[k], &V = at.motion[parent];
    const Momentum<T>& load = at.momentum[k + 1];
    p[k] = S.w.dot(load.h) + S.u.dot(load.p);
    by_q[k] = V.w.cross(S.w).dot(load.h) + (V.w.cross(S.u) + V.u.cross(S.w)).dot(load.p);
    at.momentum[parent].p += load.p;
    at.momentum[parent].h += load.h;
  }
}

// The derivatives of both by q, qd, w and beta, so many at a time.
constexpr int AT_A_TIME = 8;
using Directions = Jet<AT_A_TIME>;

struct JointMemory {
  Bodies<Directions> at;
  Directions *theta, *q, *qd, *p, *by_q;  // of all bodies, and of the joints
  double* slopes;    // 2 joints x directions: of p_k, then of dT/dq_k
  double* values;    // 2 joints
  double* node;      // 2 x unknowns: of p and F, at one node
  double* sums;      // equations x 2 x unknowns: of both sums
  double* left;      // equations x 2: the sums
};

inline int joint_directions(const Tree& tree, int betas) { return 2 * tree.joints + 3 + betas; }

inline void differentiate_joint_momenta(const Tree& tree, const Sparse& theta_of,
                                        const double* theta, const double* q, const double* qd,
                                        const Vector3<double>& w, JointMemory& memory) {
  const int K = tree.joints, all = joint_directions(tree, theta_of.columns);
  for (int first = 0; first < all; first += AT_A_TIME) {
    for (int i = 0; i < PER_BODY * tree.bodies(); ++i) memory.theta[i] = theta[i];
    Vector3<Directions> w_at(w[0], w[1], w[2]);
    for (int k = 0; k < K; ++k) {
      memory.q[k] = q[k];
      memory.qd[k] = qd[k];
    }
    const int count = std::min(AT_A_TIME, all - first);
    for (int d = 0; d < count; ++d) {
      const int k = first + d;
      if (k < K) {
        memory.q[k].v[d] = 1.0;
      } else if (k < 2 * K) {
        memory.qd[k - K].v[d] = 1.0;
      } else if (k < 2 * K + 3) {
        w_at[k - 2 * K].v[d] = 1.0;
      } else {
        const int b = k - 2 * K - 3;
        for (int e = theta_of.first[b]; e < theta_of.first[b + 1]; ++e)
          memory.theta[theta_of.row[e]].v[d] = theta_of.value[e];
      }
    }
    joint_momenta(tree, memory.theta, memory.q, memory.qd, w_at, memory.at, memory.p,
                  memory.by_q);
    for (int k = 0; k < K; ++k) {
      memory.values[k] = memory.p[k].a;
      memory.values[K + k] = memory.by_q[k].a;
      for (int d = 0; d < count; ++d) {
        memory.slopes[k * all + first + d] = memory.p[k].v[d];
        memory.slopes[(K + k) * all + first + d] = memory.by_q[k].v[d];
      }
    }
  }
}

// A row over an interval's unknowns, from one by q, qd, w and beta.
inline void write_joint_slopes(const Tree& tree, const int* corrected, const IntervalColumns& c,
                               const Calibration& calibration, const JointNode& joints,
                               const BaseNode& base, const double* by, double* row) {
  const int K = tree.joints, n = c.count();
  const double *by_q = by, *by_qd = by + K, *by_w = by + 2 * K, *by_beta = by + 2 * K + 3;
  Eigen::Map<Eigen::RowVectorXd> out(row, n);
  out = Eigen::Map<const Eigen::RowVector3d>(by_w).lazyProduct(ConstTableRows(base.dw, 3, n));
  for (int i = 0; i < c.corrected; ++i)
    for (int f = 0; f < 4; ++f)
      row[c.corrections() + f * c.corrected + i] +=
          joints.functions.value[f] * by_q[corrected[i]] +
          joints.functions.rate[f] * by_qd[corrected[i]];
  for (int b = 0; b < c.betas; ++b) row[c.beta() + b] += by_beta[b];
  const CalibrationPlaces& places = calibration.places;
  for (int i = 0; i < c.calibrations; ++i) {
    const int place = calibration.selected[i];
    double& entry = row[c.calibration() + i];
    const auto turn = [&](int k, double x, double v) { entry += x * by_q[k] + v * by_qd[k]; };
    if (place == places.joint_clock()) {
      for (int k = 0; k < K; ++k) turn(k, joints.qd[k], joints.qdd[k]);
    } else if (place < places.scale()) {
      turn(place - places.zero(), 1.0, 0.0);
    } else if (place < places.wheel()) {
      const int k = place - places.scale();
      turn(k, joints.q[k], joints.qd[k]);
    }
  }
}

// What a node adds to both sums of every equation: `weight` of the quadrature at s, and what is at
// the interval's start (-1) or end (1), or within it (0).
inline void add_joint_node(const Tree& tree, const Sparse& theta_of, const double* theta,
                           const int* corrected, const IntervalColumns& c,
                           const Calibration& calibration, const JointEquation* equation,
                           int equations, double duration, double weight, double s, int edge,
                           const JointNode& joints, const BaseNode& base,
                           JointMemory& memory) {
  const int K = tree.joints, n = c.count(), all = joint_directions(tree, c.betas);
  differentiate_joint_momenta(tree, theta_of, theta, joints.q, joints.qd, base.w, memory);
  const CalibrationPlaces& places = calibration.places;
  double *by_p = memory.node, *by_F = memory.node + n;
  for (int e = 0; e < equations; ++e) {
    const JointEquation& one = equation[e];
    const int k = one.joint;
    write_joint_slopes(tree, corrected, c, calibration, joints, base, memory.slopes + k * all,
                       by_p);
    // Spring and damper follow the joint's own position and rate.
    double* by = memory.slopes + (K + k) * all;
    double inertia = 0.0;
    for (int i = 0; i < PER_BODY * tree.bodies(); ++i) inertia += one.carried[i] * theta[i];
    const double q = joints.q[k], qd = joints.qd[k];
    const double rate = 1 + calibration.values[places.spring() + k];
    const double square = rate * rate * one.square;
    const double damped = (1 + calibration.values[places.damper() + k]) * one.damping;
    by[k] -= square * inertia;
    by[K + k] -= damped * inertia;
    for (int b = 0; b < c.betas; ++b)
      for (int x = theta_of.first[b]; x < theta_of.first[b + 1]; ++x)
        by[2 * K + 3 + b] -=
            (square * q + damped * qd) * one.carried[theta_of.row[x]] * theta_of.value[x];
    write_joint_slopes(tree, corrected, c, calibration, joints, base, by, by_F);
    for (int i = 0; i < c.calibrations; ++i) {
      const int place = calibration.selected[i];
      if (place == places.spring() + k)
        by_F[c.calibration() + i] -= 2 * rate * one.square * inertia * q;
      if (place == places.damper() + k) by_F[c.calibration() + i] -= one.damping * inertia * qd;
    }
    const double p = memory.values[k];
    const double F = memory.values[K + k] - (square * q + damped * qd) * inertia;
    const double of_p[2] = {double(edge), std::abs(edge) - 2.0 * weight / duration},
                 of_F[2] = {-weight, -weight * s};
    for (int i = 0; i < 2; ++i) {
      double* sum = memory.sums + (2 * e + i) * n;
      for (int x = 0; x < n; ++x) sum[x] += of_p[i] * by_p[x] + of_F[i] * by_F[x];
      memory.left[2 * e + i] += of_p[i] * p + of_F[i] * F;
    }
  }
}

}  // namespace orbident
