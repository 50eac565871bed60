// Joints on springs that nobody measures (passive): the rates at a node, with those of the base,
// and how all changes there with the unknowns.
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
// where L takes dy to (dw, dqd_p, de/dy dy), and C, C_e are all other unknowns' changes. In the
// tables, L is its last rows.
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
  const auto correct = [&](int k, int i, double factor) {
    for (int f = 0; f < 4 && !recorded.passive(k); ++f)
      row[c.corrections() + f * c.corrected + i] +=
          factor * (joints.functions.value[f] * by_q[k] + joints.functions.rate[f] * by_qd[k]);
  };
  for (int i = 0; i < c.corrected; ++i) correct(recorded.corrected[i], i, 1.0);
  for (const Follower& each : recorded.followers) correct(each.joint, each.correction, each.factor);
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

// Subtracts what the wheels' calibrations do to their momentum.
inline void subtract_wheels(const Recorded& recorded, const LinearisedAt& at,
                            const JointState& shown, TableRows& rows) {
  for (int c = 0; c < recorded.columns.calibrations; ++c)
    rows.col(recorded.columns.calibration() + c) -=
        by_wheels(at.calibration, shown, recorded.A_rw, at.calibration.selected[c]);
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
  Bodies<double>& at = own.at.bodies;
  pose_and_weigh(tree, theta, q, at);
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
  joint_momenta(recorded.tree, joints.qd, w, own.at);
  const double* e = own.at.values + 3 + K;
  for (int i = 0; i < P; ++i) {
    const Spring& spring = recorded.spring[i];
    const Held held(spring, at.calibration);
    p_rate[i] = e[spring.joint] - (held.square * q[i] + held.damping * qd[i]) *
                                      inertia_on(spring, recorded, at.theta);
  }
}

// Everything at a node whose state and rates are known, but s; from what `joint_momenta` left.
inline void set_passive(const Recorded& recorded, const LinearisedAt& at, PassiveMemory& own,
                        const JointNode& joints, BaseNode& base) {
  const int P = recorded.springs, K = recorded.tree.joints, n = recorded.columns.count();
  const int Y = 3 + P, N = 3 + 2 * P;
  PassiveNode& node = *base.passive;
  const int all = own.places.count();
  for (int g = 0; g < own.places.geometries; ++g)
    own.geometry[g] = displacement(recorded.tree, at.calibration, own.at.bodies.pose, own.place[g]);
  differentiate_joint_momenta(recorded.tree, recorded.theta_of, own.places, own.geometry,
                              own.displaced, own.at);
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
  OwnTable H(own.H, Y, N), L(own.L, P, Y), UH(node.UH, Y, N), A(node.A, N, N);
  const auto slope = [&](int row, int direction) { return own.at.slopes[row * all + direction]; };
  H.setZero();
  H.topLeftCorner<3, 3>() = cross_matrix(base.h_B);
  for (int i = 0; i < P; ++i) {
    const int k = recorded.spring[i].joint, e = 3 + K + k;
    for (int r = 0; r < 3; ++r) {
      H(r, 3 + i) = -slope(r, own.places.q() + k);
      L(i, r) = slope(e, r);
    }
    for (int j = 0; j < P; ++j) {
      const int other = recorded.spring[j].joint;
      H(3 + j, 3 + i) = -slope(3 + other, own.places.q() + k);
      L(i, 3 + j) = slope(e, own.places.qd() + other);
    }
    H(3 + i, Y + i) = 1.0;
  }
  UH = U.lazyProduct(H);
  A.topRows(Y) = UH;
  A.topLeftCorner<3, 3>() -= cross_matrix(base.w);
  A.bottomRows(P) = L.lazyProduct(UH);
  for (int i = 0; i < P; ++i)
    for (int j = 0; j < P; ++j)
      A(Y + i, 3 + j) +=
          slope(3 + K + recorded.spring[i].joint, own.places.q() + recorded.spring[j].joint);
  double *UC = base.dw, *C_e = own.C + Y * n, *G_p = base.G + Y * n;
  std::fill_n(UC, Y * n, 0.0);
  add_product(own.U, Y, Y, own.C, n, UC);
  std::copy_n(UC, Y * n, base.G);
  std::copy_n(C_e, P * n, G_p);
  add_product(own.L, P, Y, UC, n, G_p);

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
  add_product(base.passive->UH, rates_of_passive(recorded), states_of_passive(recorded), base.phi,
              recorded.columns.count(), base.dw);
}

// The attitude at a node, with all that follows from it but rates.
inline void set_passive_attitude(const Quaternion<double>& x_WB, BaseNode& base) {
  base.x_WB = x_WB / x_WB.norm();
  base.R_WB = quaternion_matrix(base.x_WB);
  base.h_B = base.R_WB.transpose() * base.h_cm;
}

}  // namespace orbident
