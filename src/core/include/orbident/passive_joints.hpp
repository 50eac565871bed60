// Joints on springs that nobody measures (passive): their motion along a shooting interval, with
// that of the base, and how both change with the unknowns.
//
// With y = (w, qd_p) the rates that nobody prescribes, and measured joints as they are shown,
//
//   m(y) = (h, p_p) = (R_0^T h_cm - h_rw, p_p)        linear in y: dm/dy = the inertia of y
//   dp_p/dt = e_p + tau_p                             joint_momenta.hpp
//
// so that the attitude and (q_p, p_p) are integrated (RK4). A spring and a damper hold each joint,
//
//   tau = -exp(2 x) r^2 I q - exp(y) d I qd
//
// where x and y are unknowns, and I is the inertia of all that the joint carries, about its axis,
// linear in theta: with a stiffness in place of the rate r at which it swings, the likelihood would
// have a curved valley. Changes s of (turn, q_p, p_p) follow, with U = (dm/dy)^-1,
//
//   dy = U (H s + C),   H s = ([h_B]x phi - dm/dq_p q, p - dm/dq_p q)
//   s' = A s + G,       A = L U H + (-[w]x phi, 0, de/dq_p q),   G = L U C + (0, 0, C_e)
//
// where L takes dy to (dw, dqd_p, de/dy dy), and C, C_e are all other unknowns' changes. A joint's
// unknowns at the interval's start are its position and rate; its momentum follows.
#pragma once

#include "orbident/interval_tables.hpp"

namespace orbident {

// Momenta in the order of y, and the square matrices over it and over s.
inline int rates_of_passive(const Recorded& recorded) { return 3 + recorded.springs; }
inline int states_of_passive(const Recorded& recorded) { return 3 + 2 * recorded.springs; }

using OwnTable = Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>;

// A row over an interval's unknowns without those of passive joints, from one by all directions.
inline void write_known(const Recorded& recorded, const LinearisedAt& at,
                        const DirectionPlaces& where, const JointNode& joints, const double* by,
                        double* row) {
  const IntervalColumns& c = recorded.columns;
  const double *by_q = by + where.q(), *by_qd = by + where.qd();
  std::fill_n(row, c.count(), 0.0);
  for (int i = 0; i < c.corrected; ++i) {
    const int k = recorded.corrected[i];
    for (int f = 0; f < 4 && !recorded.passive(k); ++f)
      row[c.corrections() + f * c.corrected + i] =
          joints.functions.value[f] * by_q[k] + joints.functions.rate[f] * by_qd[k];
  }
  std::copy_n(by + where.beta(), c.betas, row + c.beta());
  const CalibrationPlaces& places = at.calibration.places;
  const JointState& shown = joints.shown;
  int geometry = 0;
  for (int i = 0; i < c.calibrations; ++i) {
    const int place = at.calibration.selected[i];
    double& entry = row[c.calibration() + i];
    if (place == places.joint_clock()) {
      for (int k = 0; k < places.joints; ++k)
        if (!recorded.passive(k)) entry += shown.qd[k] * by_q[k] + shown.qdd[k] * by_qd[k];
    } else if (place < places.scale()) {
      entry = by_q[place];
    } else if (place < places.wheel()) {
      const int k = place - places.scale();
      entry = shown.q[k] * by_q[k] + shown.qd[k] * by_qd[k];
    } else if (places.is_geometry(place)) {
      entry = by[where.geometry() + geometry++];
    }
  }
}

// Subtracts what wheels' inertias and the clock do to their momentum.
inline void subtract_wheels(const Recorded& recorded, const LinearisedAt& at,
                            const JointState& shown, TableRows& rows) {
  const CalibrationPlaces& places = at.calibration.places;
  for (int c = 0; c < recorded.columns.calibrations; ++c) {
    const int place = at.calibration.selected[c], i = place - places.wheel();
    auto column = rows.col(recorded.columns.calibration() + c);
    const auto a_I = [&](int wheel) {
      return Eigen::Map<const Vector3<double>>(recorded.A_rw + 3 * wheel);
    };
    if (place == places.joint_clock())
      for (int k = 0; k < recorded.wheels; ++k) column -= shown.qdd_rw[k] * a_I(k);
    else if (i >= 0 && i < recorded.wheels)
      column -= shown.qd_rw[i] * a_I(i);
  }
}

inline double inertia_on(const Spring& spring, const Recorded& recorded, const double* theta) {
  double inertia = 0.0;
  for (int i = 0; i < PER_BODY * recorded.tree.bodies(); ++i)
    inertia += spring.carried[i] * theta[i];
  return inertia;
}

// Square rate and damping rate of a spring as they are now.
struct Held {
  double square, damping;
  Held(const Spring& spring, const Calibration& calibration) {
    const double* x = calibration.values + spring.joint;
    square = std::exp(2 * x[calibration.places.spring()]) * spring.square;
    damping = std::exp(x[calibration.places.damper()]) * spring.damping;
  }
};

// The inertia of y, and its inverse: zero where the plane holds the base. Returns m without y.
inline void invert_inertia(const Recorded& recorded, const double* theta, const double* q,
                           const double* qd, PassiveMemory& own, double* m) {
  const Tree& tree = recorded.tree;
  const int Y = rates_of_passive(recorded), K = tree.joints;
  Bodies<double>& at = own.at.plain;
  place(tree, q, at.pose, at.field);
  weigh(tree, theta, at.pose, at.mass);
  carry(tree, at.mass, at.carried);
  for (int k = 0; k < K; ++k) at.momentum[k] = momentum_of(at.carried[k + 1], at.field[k]);
  const SystemInertia<double> all = system_inertia(at.carried[0]);
  OwnTable D_qq(own.D_qq, K, K), inertia(own.inertia, Y, Y), U(own.U, Y, Y);
  joint_inertia(tree, at.field, at.momentum, all.M, D_qq);
  const auto D_q = [&](int k) -> Vector3<double> {
    return at.momentum[k].h - all.r_cm.cross(at.momentum[k].p);
  };
  std::fill_n(m, Y, 0.0);
  for (int k = 0; k < K; ++k) {
    if (recorded.passive(k)) continue;
    Eigen::Map<Vector3<double>>(m) += qd[k] * D_q(k);
    for (int i = 0; i < recorded.springs; ++i)
      m[3 + i] += qd[k] * D_qq(recorded.spring[i].joint, k);
  }
  inertia.topLeftCorner<3, 3>() = all.D;
  for (int i = 0; i < recorded.springs; ++i) {
    const int k = recorded.spring[i].joint;
    inertia.block<3, 1>(0, 3 + i) = D_q(k);
    inertia.block<1, 3>(3 + i, 0) = D_q(k).transpose();
    for (int j = 0; j < recorded.springs; ++j)
      inertia(3 + i, 3 + j) = D_qq(k, recorded.spring[j].joint);
  }
  const int held = recorded.planar ? 2 : 0;
  // Gauss and Jordan without pivots: it is positive definite.
  U.setIdentity();
  U.topRows(held).setZero();
  for (int k = held; k < Y; ++k) {
    const double pivot = inertia(k, k);
    for (int j = 0; j < Y; ++j) {
      inertia(k, j) /= pivot;
      U(k, j) /= pivot;
    }
    for (int r = held; r < Y; ++r) {
      const double share = inertia(r, k);
      for (int j = 0; r != k && j < Y; ++j) {
        inertia(r, j) -= share * inertia(k, j);
        U(r, j) -= share * U(k, j);
      }
    }
  }
  U.leftCols(held).setZero();
}

// Rates y at a state, and dp/dt.
inline void passive_rates(const Recorded& recorded, const LinearisedAt& at,
                          const Quaternion<double>& x_WB, const Vector3<double>& h_cm,
                          const double* q, const double* p, JointNode& joints, PassiveMemory& own,
                          Vector3<double>& w, double* qd, double* p_rate) {
  const int P = recorded.springs, K = recorded.tree.joints;
  double* m = own.m;
  for (int i = 0; i < P; ++i) joints.q[recorded.spring[i].joint] = q[i];
  invert_inertia(recorded, at.theta, joints.q, joints.qd, own, m);
  const Quaternion<double> unit = x_WB / x_WB.norm();
  const Vector3<double> h = quaternion_matrix(unit).transpose() * h_cm - joints.h_rw;
  const int Y = rates_of_passive(recorded);
  const OwnTable U(own.U, Y, Y);
  const auto missing = [&](int r) { return (r < 3 ? h[r] : p[r - 3]) - m[r]; };
  const auto y = [&](int r) {
    double sum = 0.0;
    for (int c = 0; c < Y; ++c) sum += U(r, c) * missing(c);
    return sum;
  };
  w = {y(0), y(1), y(2)};
  for (int i = 0; i < P; ++i) qd[i] = y(3 + i);
  for (int i = 0; i < P; ++i) joints.qd[recorded.spring[i].joint] = qd[i];
  Bodies<double>& plain = own.at.plain;
  Vector3<double> all;
  double *momenta = own.at.values + 3, *e = momenta + K;
  joint_momenta(recorded.tree, at.theta, joints.qd, w, plain, all, momenta, e);
  for (int i = 0; i < P; ++i) {
    const Spring& spring = recorded.spring[i];
    const Held held(spring, at.calibration);
    p_rate[i] = e[spring.joint] - (held.square * q[i] + held.damping * qd[i]) *
                                      inertia_on(spring, recorded, at.theta);
  }
}

// Everything at a node whose state and rates are known, but s.
inline void set_passive(const Recorded& recorded, const LinearisedAt& at, PassiveMemory& own,
                        const JointNode& joints, BaseNode& base) {
  const int P = recorded.springs, K = recorded.tree.joints, n = recorded.columns.count();
  const int Y = 3 + P, N = 3 + 2 * P;
  PassiveNode& node = *base.passive;
  const int all = own.places.count();
  for (int g = 0; g < own.places.geometries; ++g)
    own.geometry[g] = displacement(recorded.tree, at.calibration, own.at.plain.pose, own.place[g]);
  differentiate_joint_momenta(recorded.tree, recorded.theta_of, at.theta, joints.q, joints.qd,
                              base.w, own.places, own.geometry, own.displaced, own.at);
  // Springs: dp/dt, by q and qd of their own joints, by theta and by both unknowns.
  const CalibrationPlaces& places = at.calibration.places;
  OwnTable C(own.C, Y + P, n);
  for (int r = 0; r < 3; ++r)
    write_known(recorded, at, own.places, joints, own.at.slopes + r * all, own.C + r * n);
  for (int i = 0; i < P; ++i) {
    const Spring& spring = recorded.spring[i];
    const int k = spring.joint;
    const Held held(spring, at.calibration);
    const double inertia = inertia_on(spring, recorded, at.theta), q = node.q[i], qd = node.qd[i];
    const double pulls = held.square * q + held.damping * qd;
    double* by = own.at.slopes + (3 + K + k) * all;
    by[own.places.q() + k] -= held.square * inertia;
    by[own.places.qd() + k] -= held.damping * inertia;
    for (int b = 0; b < recorded.columns.betas; ++b)
      for (int x = recorded.theta_of.first[b]; x < recorded.theta_of.first[b + 1]; ++x)
        by[own.places.beta() + b] -=
            pulls * spring.carried[recorded.theta_of.row[x]] * recorded.theta_of.value[x];
    write_known(recorded, at, own.places, joints, own.at.slopes + (3 + k) * all,
                own.C + (3 + i) * n);
    write_known(recorded, at, own.places, joints, by, own.C + (Y + i) * n);
    for (int c = 0; c < recorded.columns.calibrations; ++c) {
      double& entry = C(Y + i, recorded.columns.calibration() + c);
      if (at.calibration.selected[c] == places.spring() + k) entry -= 2 * held.square * inertia * q;
      if (at.calibration.selected[c] == places.damper() + k) entry -= held.damping * inertia * qd;
    }
    node.p[i] = own.at.values[3 + k];
    node.p_rate[i] = own.at.values[3 + K + k] - pulls * inertia;
  }
  C.topRows(Y) *= -1.0;
  TableRows on_h(own.C, 3, n);
  const Matrix3<double> R_BW = base.R_WB.transpose();
  const Contributions parts = contributions(base.t);
  for (int k = 0; k < CONSERVED; ++k)
    on_h.middleCols<3>(recorded.columns.outside() + 3 * k) += parts.h_cm[k] * R_BW;
  for (int k = 0; k < 3; ++k)
    if (base.share[k] != 0.0) base.acting[k].add(ON_H, base.share[k] * R_BW, on_h);
  subtract_wheels(recorded, at, joints.shown, on_h);

  const OwnTable U(own.U, Y, Y);
  OwnTable H(own.H, Y, N), L(own.L, N, Y), UH(node.UH, Y, N), A(node.A, N, N);
  const auto slope = [&](int row, int direction) { return own.at.slopes[row * all + direction]; };
  H.setZero();
  L.setZero();
  L.topRows(Y).setIdentity();
  H.topLeftCorner<3, 3>() = cross_matrix(base.h_B);
  for (int i = 0; i < P; ++i) {
    const int k = recorded.spring[i].joint, e = 3 + K + k;
    for (int r = 0; r < 3; ++r) {
      H(r, 3 + i) = -slope(r, own.places.q() + k);
      L(Y + i, r) = slope(e, r);
    }
    for (int j = 0; j < P; ++j) {
      const int other = recorded.spring[j].joint;
      H(3 + j, 3 + i) = -slope(3 + other, own.places.q() + k);
      L(Y + i, 3 + j) = slope(e, own.places.qd() + other);
    }
    H(3 + i, Y + i) = 1.0;
  }
  UH = U.lazyProduct(H);
  A = L.lazyProduct(UH);
  A.topLeftCorner<3, 3>() -= cross_matrix(base.w);
  for (int i = 0; i < P; ++i)
    for (int j = 0; j < P; ++j)
      A(Y + i, 3 + j) +=
          slope(3 + K + recorded.spring[i].joint, own.places.q() + recorded.spring[j].joint);
  OwnTable UC(base.dw, Y, n), G(base.G, N, n);
  UC = U.lazyProduct(C.topRows(Y));
  G = L.lazyProduct(UC);
  G.bottomRows(P) += C.bottomRows(P);

  // Accelerations: U (dm/dt - what the joints' positions and measured rates change of m).
  Vector3<double> torque = Vector3<double>::Zero();
  for (int k = 0; k < 3; ++k) torque += base.share[k] * base.acting[k].value(ON_H_RATE);
  const Vector3<double> h_rate = R_BW * torque - base.w.cross(base.h_B) - joints.h_rw_rate;
  for (int i = 0; i < P; ++i) {
    node.qdd[i] = 0.0;
    for (int r = recorded.planar ? 2 : 0; r < Y; ++r) {
      const int row = r < 3 ? r : 3 + recorded.spring[r - 3].joint;
      double rate = r < 3 ? h_rate[r] : node.p_rate[r - 3];
      for (int k = 0; k < K; ++k) {
        rate -= slope(row, own.places.q() + k) * joints.qd[k];
        if (!recorded.passive(k)) rate -= slope(row, own.places.qd() + k) * joints.qdd[k];
      }
      node.qdd[i] += U(3 + i, r) * rate;
    }
  }
}

// Once s is known: the changes of y, in place of those without s.
inline void finish_passive(const Recorded& recorded, BaseNode& base) {
  const int Y = rates_of_passive(recorded), N = states_of_passive(recorded),
            n = recorded.columns.count();
  OwnTable(base.dw, Y, n) += OwnTable(base.passive->UH, Y, N).lazyProduct(OwnTable(base.phi, N, n));
}

// The attitude at a node, with all that follows from it but rates.
inline void set_passive_attitude(const Quaternion<double>& x_WB, BaseNode& base) {
  base.x_WB = x_WB / x_WB.norm();
  base.R_WB = quaternion_matrix(base.x_WB);
  base.h_B = base.R_WB.transpose() * base.h_cm;
}

// The first node of an interval: joints as its boundary has them.
inline void start_passive(const Recorded& recorded, const LinearisedAt& at, int interval,
                          PassiveMemory& own, JointNode& joints, BaseNode& base) {
  const IntervalColumns& c = recorded.columns;
  const int P = recorded.springs, N = 3 + 2 * P, n = c.count();
  PassiveNode& node = *base.passive;
  set_passive_attitude(Eigen::Map<const Quaternion<double>>(at.x_WB + 4 * interval), base);
  const double* z = at.local + interval * recorded.local() + recorded.corrections();
  for (int i = 0; i < P; ++i) {
    const Spring& spring = recorded.spring[i];
    node.q[i] = joints.q[spring.joint] = z[spring.correction];
    node.qd[i] = joints.qd[spring.joint] = z[c.corrected + spring.correction];
  }
  // D w = R_0^T h_cm - h_rw - D_q qd.
  invert_inertia(recorded, at.theta, joints.q, joints.qd, own, own.m);
  const Bodies<double>& bodies = own.at.plain;
  const SystemInertia<double> system = system_inertia(bodies.carried[0]);
  Vector3<double> h_q = Vector3<double>::Zero();
  for (int k = 0; k < recorded.tree.joints; ++k)
    h_q += joints.qd[k] * (bodies.momentum[k].h - system.r_cm.cross(bodies.momentum[k].p));
  set_law(recorded.planar, system.D, h_q + joints.h_rw, base);
  base.w = base.E * base.h_B - base.b;
  set_passive(recorded, at, own, joints, base);

  OwnTable s(base.phi, N, n);
  s.setZero();
  s.block<3, 3>(0, c.turn()).setIdentity();
  for (int i = 0; i < P; ++i) s(3 + i, c.corrections() + recorded.spring[i].correction) = 1.0;
  const int all = own.places.count();
  // dp = dm/dy dy + dm/dq_p q - C, dy = (dw, dqd) with dw = E (rows of h), all at given qd.
  const auto slope = [&](int row, int direction) { return own.at.slopes[row * all + direction]; };
  const OwnTable C(own.C, 3 + 2 * P, n);
  TableRows dw(own.K, 3, n);
  dw = C.topRows(3);
  dw.middleCols<3>(c.turn()) += cross_matrix(base.h_B);
  for (int i = 0; i < P; ++i) {
    const int k = recorded.spring[i].joint, x = c.corrections() + recorded.spring[i].correction;
    for (int r = 0; r < 3; ++r) {
      dw(r, x) -= slope(r, own.places.q() + k);
      dw(r, x + c.corrected) -= slope(r, own.places.qd() + k);
    }
  }
  for (int column = 0; column < n; ++column) dw.col(column) = (base.E * dw.col(column)).eval();
  for (int j = 0; j < P; ++j) {
    const int row = 3 + recorded.spring[j].joint;
    auto to = s.row(3 + P + j);
    to = -C.row(3 + j);
    for (int r = 0; r < 3; ++r) to += slope(row, r) * dw.row(r);
    for (int i = 0; i < P; ++i) {
      const int k = recorded.spring[i].joint, x = c.corrections() + recorded.spring[i].correction;
      to[x] += slope(row, own.places.q() + k);
      to[x + c.corrected] += slope(row, own.places.qd() + k);
    }
  }
  finish_passive(recorded, base);
}

// One RK4 step of length h: everything at `middle` and `end`, from `start`. Of both, time, momentum
// and what acts are known, and, in `own`, what measured joints and wheels do.
inline void step_passive(const Recorded& recorded, const LinearisedAt& at, double h,
                         const BaseNode& start, BaseNode& middle, BaseNode& end,
                         PassiveMemory& own) {
  const int P = recorded.springs, N = 3 + 2 * P, n = recorded.columns.count();
  const PassiveNode& from = *start.passive;
  PassiveNode &mid = *middle.passive, &to = *end.passive;
  const Quaternion<double>& x = start.x_WB;
  Quaternion<double> k[4] = {quaternion_rate(x, start.w)};
  double *q_rate[4], *p_rate[4];
  for (int i = 0; i < 4; ++i) {
    q_rate[i] = own.rates + 2 * i * P;
    p_rate[i] = own.rates + (2 * i + 1) * P;
  }
  std::copy_n(from.qd, P, q_rate[0]);
  std::copy_n(from.p_rate, P, p_rate[0]);
  for (int i = 1; i < 4; ++i) {
    const double step = i < 3 ? h / 2 : h;
    const Quaternion<double> x_i = x + step * k[i - 1];
    for (int j = 0; j < P; ++j) {
      to.q[j] = from.q[j] + step * q_rate[i - 1][j];
      to.p[j] = from.p[j] + step * p_rate[i - 1][j];
    }
    Vector3<double> w;
    passive_rates(recorded, at, x_i, i < 3 ? middle.h_cm : end.h_cm, to.q, to.p, own.joints[i / 3],
                  own, w, q_rate[i], p_rate[i]);
    k[i] = quaternion_rate(x_i, w);
  }
  for (int j = 0; j < P; ++j) {
    const auto sum = [&](double* const* f) {
      return h / 6 * (f[0][j] + 2 * f[1][j] + 2 * f[2][j] + f[3][j]);
    };
    to.q[j] = from.q[j] + sum(q_rate);
    to.p[j] = from.p[j] + sum(p_rate);
  }
  set_passive_attitude(x + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]), end);
  const auto set = [&](BaseNode& base, JointNode& joints) {
    PassiveNode& node = *base.passive;
    passive_rates(recorded, at, base.x_WB, base.h_cm, node.q, node.p, joints, own, base.w, node.qd,
                  node.p_rate);
    set_passive(recorded, at, own, joints, base);
  };
  set(end, own.joints[1]);
  // Half-way by the cubic through values and rates at both ends.
  set_passive_attitude((x + end.x_WB) / 2 + h / 8 * (k[0] - quaternion_rate(end.x_WB, end.w)),
                       middle);
  for (int j = 0; j < P; ++j) {
    mid.q[j] = (from.q[j] + to.q[j]) / 2 + h / 8 * (from.qd[j] - to.qd[j]);
    mid.p[j] = (from.p[j] + to.p[j]) / 2 + h / 8 * (from.p_rate[j] - to.p_rate[j]);
  }
  set(middle, own.joints[0]);

  // RK4 of the linear equation s' = A s + G.
  const OwnTable s_0(start.phi, N, n), G_0(start.G, N, n), G_1(middle.G, N, n), G_2(end.G, N, n);
  OwnTable s_1(middle.phi, N, n), s_2(end.phi, N, n), K_i(own.K, N, n), last(own.last, N, n);
  const OwnTable A_0(from.A, N, N), A_1(mid.A, N, N), A_2(to.A, N, N);
  K_i = A_0.lazyProduct(s_0) + G_0;
  s_1 = h / 8 * K_i;
  s_2 = s_0 + h / 6 * K_i;
  for (int i = 1; i < 4; ++i) {
    last = s_0 + (i < 3 ? h / 2 : h) * K_i;
    if (i < 3)
      K_i = A_1.lazyProduct(last) + G_1;
    else
      K_i = A_2.lazyProduct(last) + G_2;
    s_2 += (i < 3 ? h / 3 : h / 6) * K_i;
  }
  K_i = A_2.lazyProduct(s_2) + G_2;
  s_1 += (s_0 + s_2) / 2 - h / 8 * K_i;
  finish_passive(recorded, middle);
  finish_passive(recorded, end);
}

// Passive joints at a node, as they were integrated.
inline void show_passive(const Recorded& recorded, const BaseNode& base, JointNode& joints) {
  for (int i = 0; i < recorded.springs; ++i) {
    const int k = recorded.spring[i].joint;
    joints.q[k] = base.passive->q[i];
    joints.qd[k] = base.passive->qd[i];
    joints.qdd[k] = base.passive->qdd[i];
  }
}

// What passive joints add to the changes of a node's terms, in place of corrections.
inline void add_passive(const Recorded& recorded, const TermsMemory& memory, const BaseNode& base,
                        JointNode& joints) {
  const IntervalColumns& c = recorded.columns;
  const int P = recorded.springs, n = c.count();
  const OwnTable s(base.phi, 3 + 2 * P, n), dy(base.dw, 3 + P, n);
  OwnTable by(joints.by, BY_ROWS, n);
  // By these, measured joints do not change.
  by.middleCols(c.turn(), 3).setZero();
  by.middleCols(c.outside(), OUTSIDE).setZero();
  for (int i = 0; i < P; ++i)
    for (int f = 0; f < 4; ++f)
      by.col(c.corrections() + f * c.corrected + recorded.spring[i].correction).setZero();
  for (int i = 0; i < P; ++i) {
    double by_q[BY_ROWS], by_qd[BY_ROWS];
    write_change(memory.by_q[recorded.spring[i].joint], by_q, 1);
    write_change(memory.by_qd[recorded.spring[i].joint], by_qd, 1);
    for (int r = 0; r < BY_ROWS; ++r)
      by.row(r) += by_q[r] * s.row(3 + i) + by_qd[r] * dy.row(3 + i);
  }
}

// Positions and rates at the end of an interval are those at the next one's start.
inline void add_passive_continuity(const Recorded& recorded, const LinearisedAt& at, int interval,
                                   double duration, const BaseNode& end, EquationTable& equations) {
  const IntervalColumns& c = recorded.columns;
  const double* there = at.local + (interval + 1) * recorded.local() + recorded.corrections();
  const double root = walked(duration);
  for (int i = 0; i < recorded.springs; ++i) {
    const Spring& spring = recorded.spring[i];
    for (int f = 0; f < 2; ++f) {
      const int place = f * c.corrected + spring.correction;
      const double* slopes = (f ? end.dw : end.phi) + (3 + i) * c.count();
      const double weight = 1 / (spring.walk[f] * root);
      double* row = equations.add(c, slopes, weight,
                                  there[place] - (f ? end.passive->qd : end.passive->q)[i]);
      row[equations.end + recorded.corrections() + place] -= weight;
    }
  }
}

}  // namespace orbident
