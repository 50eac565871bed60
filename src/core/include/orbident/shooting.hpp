// The motion of the base along a shooting interval, and how it changes with the unknowns.
//
// Momentum conservation makes the base rate an algebraic function of joints and attitude,
//
//   w = E (h_B - h_q - h_rw),   E = D^-1,   h_B = R_0^T h_cm
//
// so that the quaternion alone is integrated (RK4). With phi the small rotation of the base, its
// own axes, a change of an unknown gives
//
//   phi' = A phi + G,   A = E [h_B]x - [w]x,   G = E (R_0^T dh_cm - dD w - dh_q)
//   dw = E [h_B]x phi + G
//
// and the same RK4 step is linear in phi and in G at its start, middle and end.
//
// Unknowns of an interval, the columns of all tables:
//
//   [turn 3 | corrections 4 x corrected | outside | beta | calibration]
//
// turn: of the attitude at the start. Corrections of joint c: a cubic with the value and rate
// (x_0, v_0) at the start and (x_1, v_1) at the end; all x_0, all v_0, all x_1, all v_1.
// Calibration: those of calibration.hpp that are selected.
#pragma once

#include "orbident/acting.hpp"
#include "orbident/combined_rows.hpp"
#include "orbident/joint_history.hpp"
#include "orbident/momentum_terms.hpp"
#include "orbident/outside.hpp"

namespace orbident {

struct IntervalColumns {
  int corrected;  // joints with corrections
  int betas;
  int calibrations;
  static constexpr int turn() { return 0; }
  static constexpr int corrections() { return 3; }
  int outside() const { return 3 + 4 * corrected; }
  int beta() const { return outside() + OUTSIDE; }
  int calibration() const { return beta() + betas; }
  int common() const { return OUTSIDE + betas + calibrations; }
  int count() const { return outside() + common(); }
};

// Rows of `by`: D (xx, xy, xz, yy, yz, zz), h_q, r_cm, v_q.
constexpr int BY_D = 0, BY_H = 6, BY_R = 9, BY_V = 12, BY_ROWS = 15;

using TableRows = Eigen::Map<Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>;
using ConstTableRows = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>;

// A joint that moves as another one's corrections move that, times a factor.
struct Follower {
  int joint, correction;
  double factor;
};

struct Followers {
  const Follower* first = nullptr;
  int count = 0;
  const Follower* begin() const { return first; }
  const Follower* end() const { return first + count; }
};

// Joints, wheels and what they mean for momentum, at a row or half-way to the next.
struct JointNode {
  double t;  // since the first row, s
  MomentumTerms terms;
  MomentumTerms rates;
  Vector3<double> h_rw;       // N m s, base axes
  Vector3<double> h_rw_rate;  // N m
  double* by;                 // BY_ROWS x unknowns: changes of the terms
  Cubics functions;           // of corrections at this time
  double *q, *qd, *qdd;       // joints each
  JointState shown;           // without corrections and calibrations
  Acting acting;
};

inline void write_change(const MomentumTerms& d, double* column, std::ptrdiff_t stride) {
  const double rows[BY_ROWS] = {d.D(0, 0), d.D(0, 1), d.D(0, 2), d.D(1, 1), d.D(1, 2),
                                d.D(2, 2), d.h_q[0],  d.h_q[1],  d.h_q[2],  d.r_cm[0],
                                d.r_cm[1], d.r_cm[2], d.v_q[0],  d.v_q[1],  d.v_q[2]};
  for (int r = 0; r < BY_ROWS; ++r) column[r * stride] = rows[r];
}

// Terms, rates and changes at the joint state (q, qd, qdd), corrections already in it.
inline void expand(const Tree& tree, const Sparse& theta_of, const double* theta,
                   const int* corrected, const Followers& followers, const IntervalColumns& columns,
                   const Cubics& functions, const double* q, const double* qd, const double* qdd,
                   TermsMemory& memory, JointNode& node) {
  const MomentsAboutS all = joint_moments(tree, theta, q, qd, memory);
  differentiate_by_joints(tree, memory);
  node.terms = about_cm(all);
  node.rates = rates_of(tree, qd, qdd, memory);
  const int n = columns.count();
  for (int c = 0; c < columns.corrected; ++c) {
    MomentumTerms by_q = memory.by_q[corrected[c]], by_qd = memory.by_qd[corrected[c]];
    for (const Follower& each : followers) {
      if (each.correction != c) continue;
      add_terms(each.factor, memory.by_q[each.joint], by_q);
      add_terms(each.factor, memory.by_qd[each.joint], by_qd);
    }
    for (int f = 0; f < 4; ++f) {
      const double x = functions.value[f], v = functions.rate[f];
      const MomentumTerms change = {x * by_q.D, x * by_q.h_q + v * by_qd.h_q, x * by_q.r_cm,
                                    x * by_q.v_q + v * by_qd.v_q};
      write_change(change, node.by + columns.corrections() + f * columns.corrected + c, n);
    }
  }
  for (int b = 0; b < columns.betas; ++b)
    write_change(derivative_by_beta(theta_of, b, all, memory), node.by + columns.beta() + b, n);
}

struct PassiveNode;

// The base at one node of the integration.
struct BaseNode {
  double t;
  const double* by;  // at least BY_R rows of changes of D and h_q
  Matrix3<double> E;
  Vector3<double> b;     // E (h_q + h_rw)
  Vector3<double> h_cm;  // inertial axes
  Quaternion<double> x_WB;
  Matrix3<double> R_WB;
  Vector3<double> h_B;
  Vector3<double> w;
  double* G;    // 3 x unknowns, and more of passive joints (passive_joints.hpp)
  double* phi;  // 3 x unknowns, and more
  double* dw;   // 3 x unknowns, and more
  PassiveNode* passive;
  double* own_by;    // memory for BY_R rows
  Acting acting[3];  // at the nodes of its row, and the share of each
  double share[3];
};

inline void set_law(bool planar, const Matrix3<double>& D, const Vector3<double>& h_moving,
                    BaseNode& at) {
  if (planar) {
    at.E.setZero();
    at.E(2, 2) = 1.0 / D(2, 2);
  } else {
    at.E = D.inverse();
  }
  at.b = at.E * h_moving;
}

inline Quaternion<double> rate_of(const BaseNode& at, const Quaternion<double>& x) {
  const Vector3<double> w = at.E * (quaternion_matrix(x).transpose() * at.h_cm) - at.b;
  return quaternion_rate(x, w);
}

// What follows from the attitude at a node.
inline void set_attitude(const Quaternion<double>& x_WB, BaseNode& at) {
  at.x_WB = x_WB / x_WB.norm();
  at.R_WB = quaternion_matrix(at.x_WB);
  at.h_B = at.R_WB.transpose() * at.h_cm;
  at.w = at.E * at.h_B - at.b;
}

// G, from the changes of D, h_q and h_cm.
inline void set_forcing(const IntervalColumns& columns, BaseNode& at) {
  const int n = columns.count();
  const Vector3<double>& w = at.w;
  // dD w + dh_q as one matrix on the rows of `by`.
  Eigen::Matrix<double, 3, BY_R> of_rows = Eigen::Matrix<double, 3, BY_R>::Zero();
  of_rows.row(0).head<3>() = w.transpose();
  of_rows(1, 1) = of_rows(2, 2) = w[0];
  of_rows(1, 3) = of_rows(2, 4) = w[1];
  of_rows(1, 4) = of_rows(2, 5) = w[2];
  of_rows.rightCols<3>().setIdentity();
  of_rows = (-at.E * of_rows).eval();
  CombinedRows sum = CombinedRows(at.G, n).zero();
  for (int k = 0; k < BY_R; k += 3)
    sum.add(of_rows.middleCols<3>(k), at.by + std::ptrdiff_t(k) * n);
  TableRows G(at.G, 3, n);
  const Matrix3<double> by_h = at.E * at.R_WB.transpose();
  const Contributions parts = contributions(at.t);
  for (int k = 0; k < CONSERVED; ++k)
    G.middleCols<3>(columns.outside() + 3 * k) += parts.h_cm[k] * by_h;
  for (int k = 0; k < 3; ++k)
    if (at.share[k] != 0.0) at.acting[k].add(ON_H, at.share[k] * by_h, G);
}

inline void set_rate_changes(const IntervalColumns& columns, BaseNode& at) {
  const int n = columns.count();
  const Matrix3<double> by_phi = at.E * cross_matrix(at.h_B);
  const Matrix3<double> one = Matrix3<double>::Identity();
  CombinedRows(at.dw, n).zero().add(by_phi, at.phi).add(one, at.G);
}

// One RK4 step of length h: everything at `middle` and `end` whose laws are set, from `start`.
inline void step(const IntervalColumns& columns, double h, const BaseNode& start, BaseNode& middle,
                 BaseNode& end) {
  const int n = columns.count();
  const Quaternion<double>& x = start.x_WB;
  const Quaternion<double> k_1 = rate_of(start, x), k_2 = rate_of(middle, x + h / 2 * k_1),
                           k_3 = rate_of(middle, x + h / 2 * k_2), k_4 = rate_of(end, x + h * k_3);
  set_attitude(x + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4), end);
  // Half-way by the cubic through values and rates at both ends.
  set_attitude((x + end.x_WB) / 2 + h / 8 * (k_1 - rate_of(end, end.x_WB)), middle);
  set_forcing(columns, middle);
  set_forcing(columns, end);

  const auto A = [](const BaseNode& at) -> Matrix3<double> {
    return at.E * cross_matrix(at.h_B) - cross_matrix(at.w);
  };
  const Matrix3<double> A_0 = A(start), A_1 = A(middle), A_2 = A(end),
                        one = Matrix3<double>::Identity();
  // RK4 of a linear equation, written out: phi_end = F phi + B_0 G_0 + B_1 G_1 + h/6 G_2.
  const Matrix3<double> K_1 = A_0, K_2 = A_1 * (one + h / 2 * K_1), K_3 = A_1 * (one + h / 2 * K_2),
                        K_4 = A_2 * (one + h * K_3);
  const Matrix3<double> F = one + h / 6 * (K_1 + 2 * K_2 + 2 * K_3 + K_4);
  const Matrix3<double> L = h / 2 * A_1, M = one + L;
  const Matrix3<double> B_0 = h / 6 * (one + 2 * L + 2 * L * L + h * A_2 * L * L);
  const Matrix3<double> B_1 = h / 6 * (2 * one + 2 * M + h * A_2 * M);
  CombinedRows(end.phi, n)
      .zero()
      .add(F, start.phi)
      .add(B_0, start.G)
      .add(B_1, middle.G)
      .add(h / 6 * one, end.G);
  CombinedRows(middle.phi, n)
      .zero()
      .add((one + h / 4 * A_0) / 2, start.phi)
      .add((one - h / 4 * A_2) / 2, end.phi)
      .add(h / 8 * one, start.G)
      .add(-h / 8 * one, end.G);
  set_rate_changes(columns, middle);
  set_rate_changes(columns, end);
}

}  // namespace orbident
