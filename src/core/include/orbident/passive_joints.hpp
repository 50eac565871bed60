// The motion of passive joints along a shooting interval, with that of the base: both, and their
// changes, are integrated by RK4 (passive_rates.hpp). A joint's unknowns at the interval's start
// are its position and rate; its momentum follows.
#pragma once

#include "orbident/passive_rates.hpp"

namespace orbident {

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
  const Bodies<double>& bodies = own.at.bodies;
  const SystemInertia<double> system = system_inertia(bodies.carried[0]);
  Vector3<double> h_q = Vector3<double>::Zero();
  for (int k = 0; k < recorded.tree.joints; ++k)
    h_q += joints.qd[k] * (bodies.momentum[k].h - system.r_cm.cross(bodies.momentum[k].p));
  set_law(recorded.planar, system.D, h_q + joints.h_rw, base);
  base.w = base.E * base.h_B - base.b;
  joint_momenta(recorded.tree, joints.qd, base.w, own.at);
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
  const int size = N * n;
  double *K = own.K, *last = own.last, *s_1 = middle.phi, *s_2 = end.phi;
  const auto set_rate = [&](const BaseNode& base, const double* s) {
    std::copy_n(base.G, size, K);
    add_product(base.passive->A, N, N, s, n, K);
  };
  set_rate(start, start.phi);
  std::fill_n(s_1, size, 0.0);
  add_scaled(h / 8, K, size, s_1);
  std::copy_n(start.phi, size, s_2);
  add_scaled(h / 6, K, size, s_2);
  for (int i = 1; i < 4; ++i) {
    std::copy_n(start.phi, size, last);
    add_scaled(i < 3 ? h / 2 : h, K, size, last);
    set_rate(i < 3 ? middle : end, last);
    add_scaled(i < 3 ? h / 3 : h / 6, K, size, s_2);
  }
  set_rate(end, s_2);
  add_scaled(0.5, start.phi, size, s_1);
  add_scaled(0.5, s_2, size, s_1);
  add_scaled(-h / 8, K, size, s_1);
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
