// The base's motion along given joint motions, and the gradient of a scalar of both.
//
// Momentum conservation makes the base rate a function of attitude and joints (Eqs. 2, 17, 18),
//
//   w = E (R_0^T h_cm - h_rw - h_q),   E = (D - D_free)^-1,   h_q = D_q qd,
//
// with D_free and h_rw of the wheels (a free one keeps its absolute spin). The attitude follows by
// RK4, with nodes and mid-nodes given. A change of the joints changes a rate w_s of a stage by
//
//   dw_s = E (d(R_0^T h_cm) - d h_rs(q, qd, w_s)),   d at constant w_s,
//
// so the reverse pass needs no derivative of E: with f_w = df/dw_s and a = E f_w, the gradient is
// that of -a . h_rs, and a x (R_0^T h_cm) is the one with respect to a small rotation of the base.
#pragma once

#include "orbident/equations_of_motion.hpp"
#include "orbident/momentum_adjoint.hpp"

namespace orbident {

// A robot that floats, and its constant momentum.
struct Floating {
  Robot robot;
  bool planar;
  Matrix3<double> D_free;   // what free wheels add to D, base axes
  Vector3<double> h_rw;     // momentum of the wheels where w = 0, base axes
  Vector3<double> h_cm;     // inertial axes
  Quaternion<double> x_WB;  // at the start
};

// The law of the base rate at one node: w = E (R_0^T h_cm - h).
struct NodeLaw {
  Matrix3<double> E;
  Vector3<double> h;

  Vector3<double> rate(const Quaternion<double>& x_WB, const Vector3<double>& h_cm) const {
    return E * (quaternion_matrix(x_WB).transpose() * h_cm - h);
  }
};

// From a configured state; in the plane E is 1 / D_zz alone.
inline NodeLaw node_law(const Floating& floating, const Bodies<double>& at, const double* qd) {
  const SystemInertia<double> all = system_inertia(at.carried[0]);
  NodeLaw law{Matrix3<double>::Zero(), floating.h_rw};
  for (int k = 0; k < floating.robot.tree.joints; ++k)
    law.h += qd[k] * (at.momentum[k].h - all.r_cm.cross(at.momentum[k].p));
  const Matrix3<double> D = all.D - floating.D_free;
  if (floating.planar)
    law.E(2, 2) = 1.0 / D(2, 2);
  else
    law.E = D.inverse();
  return law;
}

// The quaternion's gradient of a gradient with respect to a small rotation, base axes.
inline Quaternion<double> rotation_gradient(const Quaternion<double>& x_WB,
                                            const Vector3<double>& f_turn) {
  return 4.0 / x_WB.squaredNorm() * quaternion_rate(x_WB, f_turn);
}

// One evaluation of x' = 1/2 x (w, 0), and its reverse.
struct Stage {
  Quaternion<double> x;
  Vector3<double> w;
  Vector3<double> a = Vector3<double>::Zero();  // E df/dw

  Quaternion<double> rate() const { return quaternion_rate(x, w); }

  // df/dx from the gradient f_k with respect to x'.
  Quaternion<double> reverse(const NodeLaw& law, const Vector3<double>& h_cm,
                             const Quaternion<double>& f_k) {
    const Vector3<double> v = x.head<3>(), f = f_k.head<3>();
    a = law.E * (0.5 * (x[3] * f + f.cross(v) - f_k[3] * v));
    const Vector3<double> h_B = quaternion_matrix(x).transpose() * h_cm;
    Quaternion<double> f_x = rotation_gradient(x, a.cross(h_B));
    f_x.head<3>() += 0.5 * (w.cross(f) - f_k[3] * w);
    f_x[3] += 0.5 * f.dot(w);
    return f_x;
  }
};

// One step of RK4 from x: laws at its start, middle and end.
struct Step {
  const NodeLaw* law;  // 3
  Vector3<double> h_cm;
  double dt;
  Stage stage[4];
  Quaternion<double> end;  // before it is normalised

  Step(const NodeLaw* law_, const Vector3<double>& h_cm_, double dt_, const Quaternion<double>& x)
      : law(law_), h_cm(h_cm_), dt(dt_) {
    const auto at = [this](int s, const Quaternion<double>& x_s) {
      stage[s].x = x_s;
      stage[s].w = law[(s + 1) / 2].rate(x_s, h_cm);
      return stage[s].rate();
    };
    const Quaternion<double> k_1 = at(0, x), k_2 = at(1, x + dt / 2 * k_1);
    const Quaternion<double> k_3 = at(2, x + dt / 2 * k_2), k_4 = at(3, x + dt * k_3);
    end = x + dt / 6 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4);
  }

  // df/dx at the start from f_x at the normalised end; leaves a in every stage.
  Quaternion<double> reverse(const Quaternion<double>& f_x) {
    const double norm = end.norm();
    const Quaternion<double> unit = end / norm, f = (f_x - unit * unit.dot(f_x)) / norm;
    const Quaternion<double> f_4 = stage[3].reverse(law[2], h_cm, dt / 6 * f);
    const Quaternion<double> f_3 = stage[2].reverse(law[1], h_cm, dt / 3 * f + dt * f_4);
    const Quaternion<double> f_2 = stage[1].reverse(law[1], h_cm, dt / 3 * f + dt / 2 * f_3);
    const Quaternion<double> f_1 = stage[0].reverse(law[0], h_cm, dt / 6 * f + dt / 2 * f_2);
    return f + f_1 + f_2 + f_3 + f_4;
  }
};

// Adds the gradient of a . h_rs(q, qd, w) + r . r_cm + v . (w x r_cm + J_cm qd) at a configured
// state; returns df/dw.
inline Vector3<double> add_momentum_gradient(const Robot& robot, Bodies<double>& at, Wrenches& room,
                                             const Vector3<double>& a, const Vector3<double>& r,
                                             const Vector3<double>& v, const Vector3<double>& w,
                                             const double* qd, double* f_q, double* f_qd) {
  move(robot.tree, at.field, w, qd, at.motion);
  Vector3<double> p = Vector3<double>::Zero();
  for (int i = 0; i < robot.tree.bodies(); ++i)
    p += at.mass[i].m * at.motion[i].u + at.motion[i].w.cross(at.mass[i].s);
  const MomentumGradients wrenches(a, r, v, at.carried[0], p, at.mass, at.motion);
  return momentum_adjoint(robot.tree, at.field, qd, wrenches, room, f_q, f_qd);
}

}  // namespace orbident
