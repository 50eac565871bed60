// The inertia of the system at one configuration (Eqs. 3, 5, 6), base axes.
//
//   h_rs = D w + D_q qd            angular momentum about the system CM
//   2 T  = w D w + 2 w D_q qd + qd D_qq qd
//
// by composite bodies: with the mass m, first moment s and inertia J about S of all that joint k
// carries, and its field (w_k, u_k), the momentum of that motion is
//
//   p_k = m u_k + w_k x s,   h_k = s x u_k + J w_k.
//
// Koenig: about the CM, subtract what the whole mass at the CM would have. All is linear in theta
// but for one division by M, so a massless link is nothing special.
#pragma once

#include "orbident/momentum.hpp"

namespace orbident {

// Mass, first moment and inertia about S, of one body or of several.
template <class T>
struct Mass {
  T m;
  Vector3<T> s;
  Matrix3<T> J;
};

// Each body's theta_i, moved from its own frame to S and base axes.
template <class T, class Theta>
void weigh(const Tree& tree, const Theta* theta, const Pose<T>* pose, Mass<T>* mass) {
  for (int i = 0; i < tree.bodies(); ++i, theta += PER_BODY) {
    const Matrix3<T>& R = pose[i].R;
    const Vector3<T>& d = pose[i].d;
    const T m = T(theta[0]);
    const Vector3<T> s = R * Vector3<T>(T(theta[1]), T(theta[2]), T(theta[3]));
    Matrix3<T> I;
    I << T(theta[4]), T(theta[5]), T(theta[7]),  //
        T(theta[5]), T(theta[6]), T(theta[8]),   //
        T(theta[7]), T(theta[8]), T(theta[9]);
    // Integral of -[d + r]x^2 dm = R I R^T + (d . e) 1 - (d e^T + e d^T) / 2.
    const Vector3<T> e = s + T(0.5) * m * d;
    const Matrix3<T> RI = R * I;
    const T de = T(2) * d.dot(e);
    Matrix3<T>& J = mass[i].J;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b <= a; ++b)
        J(a, b) = J(b, a) = RI.row(a).dot(R.row(b)) - d[a] * e[b] - e[a] * d[b];
      J(a, a) += de;
    }
    mass[i].m = m;
    mass[i].s = s + m * d;
  }
}

// The composite of each body: itself and all that it carries.
template <class T>
void carry(const Tree& tree, const Mass<T>* mass, Mass<T>* carried) {
  for (int i = 0; i < tree.bodies(); ++i) carried[i] = mass[i];
  for (int k = tree.joints - 1; k >= 0; --k) {
    Mass<T>& parent = carried[tree.joint[k].parent];
    parent.m += carried[k + 1].m;
    parent.s += carried[k + 1].s;
    parent.J += carried[k + 1].J;
  }
}

// Momentum of what joint k carries at unit rate: linear p and angular h, about S.
template <class T>
struct Momentum {
  Vector3<T> p;
  Vector3<T> h;
  static Momentum zero() { return {Vector3<T>::Zero(), Vector3<T>::Zero()}; }
};

template <class T>
Momentum<T> momentum_of(const Mass<T>& carried, const Motion<T>& field) {
  return {carried.m * field.u + field.w.cross(carried.s),
          carried.s.cross(field.u) + carried.J * field.w};
}

// The power of a momentum's rate along a field.
template <class T>
T along(const Motion<T>& field, const Momentum<T>& of) {
  return field.w.dot(of.h) + field.u.dot(of.p);
}

// What momentum and velocity need at one configuration.
template <class T>
struct SystemInertia {
  T M;
  Vector3<T> r_cm;  // from S to the system CM, m
  Matrix3<T> D;
};

template <class T>
SystemInertia<T> system_inertia(const Mass<T>& all) {
  const Matrix3<T> s_x = cross_matrix(all.s);
  return {all.m, all.s / all.m, all.J + s_x * s_x / all.m};
}

// D_q and J_cm (3 x joints): the velocity of the CM relative to S is w x r_cm + J_cm qd.
template <class T>
void joint_columns(const Tree& tree, const Motion<T>* field, const Mass<T>* carried,
                   Momentum<T>* momentum, Rows3<T> D_q, Rows3<T> J_cm) {
  const Mass<T>& all = carried[0];
  for (int k = 0; k < tree.joints; ++k) {
    momentum[k] = momentum_of(carried[k + 1], field[k]);
    D_q.col(k) = momentum[k].h - all.s.cross(momentum[k].p) / all.m;
    J_cm.col(k) = momentum[k].p / all.m;
  }
}

// D_qq (joints x joints): the energy of each motion that carries k, in the momentum that k carries.
template <class T, class Matrix>
void joint_inertia(const Tree& tree, const Motion<T>* field, const Momentum<T>* momentum,
                   const T& M, Matrix&& D_qq) {
  const T per_M = T(1) / M;
  for (int k = 0; k < tree.joints; ++k) {
    const Vector3<T> v_cm = momentum[k].p * per_M;
    for (int j = 0; j <= k; ++j) D_qq(k, j) = -v_cm.dot(momentum[j].p);
    for (int j = k; j >= 0; j = tree.joint[j].parent - 1)
      D_qq(k, j) += field[j].w.dot(momentum[k].h) + field[j].u.dot(momentum[k].p);
    for (int j = 0; j < k; ++j) D_qq(j, k) = D_qq(k, j);
  }
}

}  // namespace orbident
