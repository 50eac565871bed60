// What momentum and velocity need of the joints, and its derivatives (Eqs. 3 and 30), base axes:
//
//   D w + D_q qd = h_rs,   r_cm,   v_q = J_cm qd
//
// First about S, where all is a sum over bodies:
//
//   mass m, first moment s, inertia J;  p, h: momentum of the joints' motion alone
//
// then about the system CM (Koenig):
//
//   D = J + [s]x [s]x / m,   D_q qd = h - s x p / m,   r_cm = s / m,   J_cm qd = p / m.
//
// By q_k: all that joint k carries (composite m_c, s_c, J_c, momentum p_c, h_c) is displaced
// rigidly by the joint's field (w, u), but the motion V_k of the body that carries it does not turn
// with it:
//
//   dm = 0,  ds = m_c u + w x s_c,  dJ = [w]x J_c - J_c [w]x - [u]x [s_c]x - [s_c]x [u]x
//   dp = w x p_c - p(V'),  dh = w x h_c + u x p_c - h(V'),  V' = (w x w_k, w x u_k + u x w_k)
//
// with p(V'), h(V') the momentum of the composite at the motion V'.
#pragma once

#include "orbident/equations_of_motion.hpp"
#include "orbident/regressors.hpp"

namespace orbident {

// About the system CM: the terms, their rates in time, or their changes with an unknown.
struct MomentumTerms {
  Matrix3<double> D;
  Vector3<double> h_q;   // D_q qd
  Vector3<double> r_cm;  // from S
  Vector3<double> v_q;   // J_cm qd
};

inline void add_terms(double factor, const MomentumTerms& d, MomentumTerms& to) {
  to.D += factor * d.D;
  to.h_q += factor * d.h_q;
  to.r_cm += factor * d.r_cm;
  to.v_q += factor * d.v_q;
}

// About S, of one body or of several.
struct MomentsAboutS {
  double m;
  Vector3<double> s;
  Matrix3<double> J;
  Vector3<double> p;
  Vector3<double> h;
};

// [a]x [b]x + [b]x [a]x.
inline Matrix3<double> crossed(const Vector3<double>& a, const Vector3<double>& b) {
  const Matrix3<double> ab = a * b.transpose();
  Matrix3<double> sum = ab + ab.transpose();
  sum.diagonal().array() -= 2.0 * a.dot(b);
  return sum;
}

inline MomentumTerms about_cm(const MomentsAboutS& a) {
  return {a.J + crossed(a.s, a.s) / (2.0 * a.m), a.h - a.s.cross(a.p) / a.m, a.s / a.m, a.p / a.m};
}

// How the terms at `a` change when its moments change by `d`.
inline MomentumTerms change_about_cm(const MomentsAboutS& a, const MomentsAboutS& d) {
  const double part = d.m / a.m;
  const Vector3<double> s = d.s - part * a.s, p = d.p - part * a.p;
  return {d.J + crossed(a.s, d.s - 0.5 * part * a.s) / a.m,
          d.h - (d.s.cross(a.p) + a.s.cross(p)) / a.m, s / a.m, p / a.m};
}

// The caller's memory for the terms of one joint state.
struct TermsMemory {
  Bodies<double> at;
  Momentum<double>* carried_momentum;  // bodies: of the joints' motion
  MomentumTerms* by_q;                 // joints
  MomentumTerms* by_qd;                // joints
  MomentsAboutS all;
};

// The moments that the entry `parameter` of theta_i gives at unit size.
inline MomentsAboutS unit_moments(const Pose<double>& pose, const Motion<double>& motion,
                                  int parameter) {
  const Vector3<double>&d = pose.d, &w = motion.w;
  const Vector3<double> v = motion.u + w.cross(d), zero = Vector3<double>::Zero();
  if (parameter == 0) return {1.0, d, crossed(d, d) * -0.5, v, d.cross(v)};
  if (parameter <= 3) {
    const Vector3<double> r = pose.R.col(parameter - 1), wr = w.cross(r);
    return {0.0, r, -crossed(d, r), wr, d.cross(wr) + r.cross(v)};
  }
  constexpr int ROW[] = {0, 0, 1, 0, 1, 2}, COLUMN[] = {0, 1, 1, 2, 2, 2};
  const int a = ROW[parameter - 4], b = COLUMN[parameter - 4];
  const Matrix3<double> half = pose.R.col(a) * pose.R.col(b).transpose();
  const Matrix3<double> J = a == b ? half : Matrix3<double>(half + half.transpose());
  return {0.0, zero, J, zero, J * w};
}

// The moments of all bodies at (q, qd), left in `memory` for the derivatives.
inline MomentsAboutS joint_moments(const Tree& tree, const double* theta, const double* q,
                                   const double* qd, TermsMemory& memory) {
  Bodies<double>& at = memory.at;
  place(tree, q, at.pose, at.field);
  move(tree, at.field, Vector3<double>(Vector3<double>::Zero()), qd, at.motion);
  weigh(tree, theta, at.pose, at.mass);
  carry(tree, at.mass, at.carried);
  for (int i = 0; i < tree.bodies(); ++i)
    memory.carried_momentum[i] = momentum_of(at.mass[i], at.motion[i]);
  for (int k = tree.joints - 1; k >= 0; --k) {
    Momentum<double>& parent = memory.carried_momentum[tree.joint[k].parent];
    parent.p += memory.carried_momentum[k + 1].p;
    parent.h += memory.carried_momentum[k + 1].h;
  }
  const Mass<double>& all = at.carried[0];
  memory.all = {all.m, all.s, all.J, memory.carried_momentum[0].p, memory.carried_momentum[0].h};
  return memory.all;
}

// The derivative by a rigid displacement of joint k and all that it carries, along a field.
inline MomentumTerms displaced(const Tree& tree, const TermsMemory& memory, int k,
                               const Motion<double>& field) {
  const Motion<double>& V = memory.at.motion[tree.joint[k].parent];
  const Mass<double>& load = memory.at.carried[k + 1];
  const Momentum<double>& moving = memory.carried_momentum[k + 1];
  const Vector3<double>&w = field.w, &u = field.u;
  const Momentum<double> held =
      momentum_of(load, Motion<double>{w.cross(V.w), w.cross(V.u) + u.cross(V.w)});
  const Matrix3<double> turned = cross_matrix(w) * load.J;
  return change_about_cm(
      memory.all,
      {0.0, momentum_of(load, field).p, turned + turned.transpose() - crossed(u, load.s),
       w.cross(moving.p) - held.p, w.cross(moving.h) + u.cross(moving.p) - held.h});
}

// The derivatives by every q and qd, from what `joint_moments` left.
inline void differentiate_by_joints(const Tree& tree, TermsMemory& memory) {
  const MomentsAboutS& all = memory.all;
  for (int k = 0; k < tree.joints; ++k) {
    const Momentum<double> unit = momentum_of(memory.at.carried[k + 1], memory.at.field[k]);
    memory.by_q[k] = displaced(tree, memory, k, memory.at.field[k]);
    memory.by_qd[k] = {Matrix3<double>::Zero(), unit.h - all.s.cross(unit.p) / all.m,
                       Vector3<double>::Zero(), unit.p / all.m};
  }
}

// The rates in time: d/dt = sum_k qd_k d/dq_k + qdd_k d/dqd_k.
inline MomentumTerms rates_of(const Tree& tree, const double* qd, const double* qdd,
                              const TermsMemory& memory) {
  MomentumTerms rate = {Matrix3<double>::Zero(), Vector3<double>::Zero(), Vector3<double>::Zero(),
                        Vector3<double>::Zero()};
  for (int k = 0; k < tree.joints; ++k) {
    const MomentumTerms &by_q = memory.by_q[k], &by_qd = memory.by_qd[k];
    rate.D += qd[k] * by_q.D;
    rate.h_q += qd[k] * by_q.h_q + qdd[k] * by_qd.h_q;
    rate.r_cm += qd[k] * by_q.r_cm;
    rate.v_q += qd[k] * by_q.v_q + qdd[k] * by_qd.v_q;
  }
  return rate;
}

// The derivative by the parameter `column` of beta, with theta = theta_of beta.
inline MomentumTerms derivative_by_beta(const Sparse& theta_of, int column,
                                        const MomentsAboutS& all, const TermsMemory& memory) {
  const Vector3<double> zero = Vector3<double>::Zero();
  MomentsAboutS sum = {0.0, zero, Matrix3<double>::Zero(), zero, zero};
  for (int e = theta_of.first[column]; e < theta_of.first[column + 1]; ++e) {
    const int body = theta_of.row[e] / PER_BODY;
    const double value = theta_of.value[e];
    const MomentsAboutS unit =
        unit_moments(memory.at.pose[body], memory.at.motion[body], theta_of.row[e] % PER_BODY);
    sum.m += value * unit.m;
    sum.s += value * unit.s;
    sum.J += value * unit.J;
    sum.p += value * unit.p;
    sum.h += value * unit.h;
  }
  return change_about_cm(all, sum);
}

}  // namespace orbident
