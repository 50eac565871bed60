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
  Momentum<double>* unit;              // bodies
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
    const Vector3<double> w = value(S.w), u = value(S.u), by_w = X.w.cross(w),
                          by_u = X.w.cross(u) + X.u.cross(w), by_d = X.u + X.w.cross(value(body.d));
    for (int r = 0; r < 3; ++r) {
      add(by_w[r], S.w[r]);
      add(by_u[r], S.u[r]);
      add(by_d[r], body.d[r]);
      const Vector3<double> by_R = X.w.cross(value(body.R.col(r)));
      for (int i = 0; i < 3; ++i) add(by_R[i], body.R(i, r));
    }
  }
}

// The derivatives in directions from `first` to `end`: none by beta.
inline void differentiate_directions(const Tree& tree, const double* theta, const double* q,
                                     const double* qd, const Vector3<double>& w,
                                     const DirectionPlaces& places, const Motion<double>* geometry,
                                     const int* displaced, int first, int end,
                                     JointMomentaMemory& memory) {
  const int K = tree.joints, all = places.count();
  for (; first < end; first += AT_A_TIME) {
    const int here = std::min(AT_A_TIME, end - first);
    for (int i = 0; i < PER_BODY * tree.bodies(); ++i) memory.theta[i] = theta[i];
    Vector3<Directions> w_at(w[0], w[1], w[2]), h;
    for (int k = 0; k < K; ++k) {
      memory.q[k] = q[k];
      memory.qd[k] = qd[k];
    }
    for (int d = 0; d < here; ++d) {
      const int at = first + d;
      if (at < places.qd())
        w_at[at].v[d] = 1.0;
      else if (at < places.q())
        memory.qd[at - places.qd()].v[d] = 1.0;
      else if (at < places.beta())
        memory.q[at - places.q()].v[d] = 1.0;
    }
    place(tree, memory.q, memory.at.pose, memory.at.field);
    for (int d = 0; d < here; ++d) {
      const int g = first + d - places.geometry();
      if (g >= 0) displace(tree, displaced[g], geometry[g], d, memory.at);
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

// By a parameter of beta, from what `joint_momenta` left in `plain`: unit bodies move as theirs,
// and the system CM moves with them.
inline void differentiate_by_beta(const Tree& tree, const Sparse& theta_of, int b,
                                  const DirectionPlaces& places, JointMomentaMemory& memory) {
  const Bodies<double>& at = memory.plain;
  const int K = tree.joints, all = places.count(), column = places.beta() + b;
  for (int i = 0; i < tree.bodies(); ++i)
    memory.unit[i] = {Vector3<double>::Zero(), Vector3<double>::Zero()};
  for (int x = theta_of.first[b]; x < theta_of.first[b + 1]; ++x) {
    const int body = theta_of.row[x] / PER_BODY;
    const MomentsAboutS unit =
        unit_moments(at.pose[body], at.motion[body], theta_of.row[x] % PER_BODY);
    memory.unit[body].p += theta_of.value[x] * unit.p;
    memory.unit[body].h += theta_of.value[x] * unit.h;
  }
  for (int k = K - 1; k >= 0; --k) {
    Momentum<double>& parent = memory.unit[tree.joint[k].parent];
    parent.p += memory.unit[k + 1].p;
    parent.h += memory.unit[k + 1].h;
  }
  const Vector3<double> back = -memory.unit[0].p / at.carried[0].m;
  const auto load_of = [&](int body) -> Momentum<double> {
    const Mass<double>& carried = at.carried[body];
    return {memory.unit[body].p + carried.m * back, memory.unit[body].h + carried.s.cross(back)};
  };
  const Momentum<double> whole = load_of(0);
  for (int r = 0; r < 3; ++r) memory.slopes[r * all + column] = whole.h[r];
  for (int k = 0; k < K; ++k) {
    const Motion<double>&S = at.field[k], &V = at.motion[tree.joint[k].parent];
    const Momentum<double> load = load_of(k + 1);
    memory.slopes[(3 + k) * all + column] = S.w.dot(load.h) + S.u.dot(load.p);
    memory.slopes[(3 + K + k) * all + column] = V.w.cross(S.w).dot(load.h) +
                                                (V.w.cross(S.u) + V.u.cross(S.w)).dot(load.p) +
                                                back.cross(S.w).dot(at.momentum[k + 1].p);
  }
}

// Values, and all derivatives.
inline void differentiate_joint_momenta(const Tree& tree, const Sparse& theta_of,
                                        const double* theta, const double* q, const double* qd,
                                        const Vector3<double>& w, const DirectionPlaces& places,
                                        const Motion<double>* geometry, const int* displaced,
                                        JointMomentaMemory& memory) {
  Bodies<double>& plain = memory.plain;
  Vector3<double> h;
  place(tree, q, plain.pose, plain.field);
  joint_momenta(tree, theta, qd, w, plain, h, memory.values + 3, memory.values + 3 + tree.joints);
  carry(tree, plain.mass, plain.carried);
  for (int b = 0; b < places.betas; ++b) differentiate_by_beta(tree, theta_of, b, places, memory);
  const auto directions = [&](int first, int end) {
    differentiate_directions(tree, theta, q, qd, w, places, geometry, displaced, first, end,
                             memory);
  };
  directions(0, places.beta());
  directions(places.geometry(), places.count());
}

}  // namespace orbident
