// The momenta of the joints and how the energy changes with their positions (Eq. 11), without
// accelerations, and the derivatives of both.
//
//   h   = D w + D_q qd                          of all bodies, base axes
//   p_k = S_k . h_k                             dT/dqd_k
//   e_k = S_k' . h_k,   S_k' = V_k x S_k        dT/dq_k
//
// with S_k the field of joint k, h_k the momentum of all that it carries, with the system CM at
// rest, and V_k the motion of the body that carries the joint. h and p are linear in w and qd.
#pragma once

#include "orbident/calibration.hpp"
#include "orbident/jet.hpp"

namespace orbident {

// The bodies are placed.
template <class T>
void joint_momenta(const Tree& tree, const T* theta, const T* qd, const Vector3<T>& w,
                   Bodies<T>& at, Vector3<T>& h, T* p, T* e) {
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
    e[k] = V.w.cross(S.w).dot(load.h) + (V.w.cross(S.u) + V.u.cross(S.w)).dot(load.p);
    at.momentum[parent].p += load.p;
    at.momentum[parent].h += load.h;
  }
  h = at.momentum[0].h;
}

// Derivatives, so many at a time.
constexpr int AT_A_TIME = 8;
using Directions = Jet<AT_A_TIME>;

// By w, by qd, by q, by beta, and by the calibrations of geometry.
struct DirectionPlaces {
  int joints, betas, geometries;
  int qd() const { return 3; }
  int q() const { return 3 + joints; }
  int beta() const { return 3 + 2 * joints; }
  int geometry() const { return beta() + betas; }
  int count() const { return geometry() + geometries; }
};

struct JointMomentaMemory {
  Bodies<Directions> at;
  Bodies<double> plain;
  Directions *theta, *q, *qd, *p, *e;  // of all bodies, and of the joints
  double* slopes;                      // h, p, e: 3 + 2 joints x directions
  double* values;                      // 3 + 2 joints
};

// A displacement of joint k and all that it carries along a field, in one direction.
inline void displace(const Tree& tree, int k, const Motion<double>& X, int direction,
                     Bodies<Directions>& at) {
  const auto add = [direction](double by, Directions& to) { to.v[direction] += by; };
  for (int j = k; j < tree.joints; ++j) {
    int above = j;
    while (above > k) above = tree.joint[above].parent - 1;
    if (above != k) continue;
    Pose<Directions>& body = at.pose[j + 1];
    Motion<Directions>& S = at.field[j];
    const auto value = [](const Vector3<Directions>& x) {
      return Vector3<double>(x[0].a, x[1].a, x[2].a);
    };
    const Vector3<double> w = value(S.w), u = value(S.u),
                          by_w = X.w.cross(w), by_u = X.w.cross(u) + X.u.cross(w),
                          by_d = X.u + X.w.cross(value(body.d));
    for (int r = 0; r < 3; ++r) {
      add(by_w[r], S.w[r]);
      add(by_u[r], S.u[r]);
      add(by_d[r], body.d[r]);
      const Vector3<double> by_R = X.w.cross(value(body.R.col(r)));
      for (int i = 0; i < 3; ++i) add(by_R[i], body.R(i, r));
    }
  }
}

// Values, and the derivatives by the first `count` directions.
inline void differentiate_joint_momenta(const Tree& tree, const Sparse& theta_of,
                                        const double* theta, const double* q, const double* qd,
                                        const Vector3<double>& w, const DirectionPlaces& places,
                                        const Motion<double>* geometry, const int* displaced_joint,
                                        int count, JointMomentaMemory& memory) {
  const int K = tree.joints, all = places.count();
  for (int first = 0; first < count; first += AT_A_TIME) {
    const int here = std::min(AT_A_TIME, count - first);
    for (int i = 0; i < PER_BODY * tree.bodies(); ++i) memory.theta[i] = theta[i];
    Vector3<Directions> w_at(w[0], w[1], w[2]), h;
    for (int k = 0; k < K; ++k) {
      memory.q[k] = q[k];
      memory.qd[k] = qd[k];
    }
    for (int d = 0; d < here; ++d) {
      const int place = first + d;
      if (place < places.qd()) {
        w_at[place].v[d] = 1.0;
      } else if (place < places.q()) {
        memory.qd[place - places.qd()].v[d] = 1.0;
      } else if (place < places.beta()) {
        memory.q[place - places.q()].v[d] = 1.0;
      } else if (place < places.geometry()) {
        const int b = place - places.beta();
        for (int x = theta_of.first[b]; x < theta_of.first[b + 1]; ++x)
          memory.theta[theta_of.row[x]].v[d] = theta_of.value[x];
      }
    }
    orbident::place(tree, memory.q, memory.at.pose, memory.at.field);
    for (int d = 0; d < here; ++d) {
      const int g = first + d - places.geometry();
      if (g >= 0) displace(tree, displaced_joint[g], geometry[g], d, memory.at);
    }
    joint_momenta(tree, memory.theta, memory.qd, w_at, memory.at, h, memory.p, memory.e);
    for (int row = 0; row < 3 + 2 * K; ++row) {
      const Directions& x =
          row < 3 ? h[row] : (row < 3 + K ? memory.p[row - 3] : memory.e[row - 3 - K]);
      memory.values[row] = x.a;
      for (int d = 0; d < here; ++d) memory.slopes[row * all + first + d] = x.v[d];
    }
  }
}

}  // namespace orbident
