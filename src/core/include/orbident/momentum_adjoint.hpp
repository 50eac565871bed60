// The gradient of a scalar f(S, P, A) of one sample's momentum columns, by the reverse pass.
//
// Given df/dS, df/dP and df/dA, each body has a gradient with respect to a small rotation and
// displacement of its frame, gathered as the wrench (moment about S, force)
//
//   turn_i = (sum_j r_j x df/dr_j + d x df/dd,  df/dd),   rate_i = (df/dw, df/du),
//
// where r_j are the columns of R_i. Joint k displaces all that it carries by its field (w_k, u_k),
// and turns their fields with it; with sums over all that k carries,
//
//   df/dqd_k = (w_k, u_k) . rate
//   df/dq_k  = (w_k, u_k) . (turn + sum_j qd_j (w_j x rate_j.w + u_j x rate_j.u,  w_j x rate_j.u)).
#pragma once

#include "orbident/inertia.hpp"
#include "orbident/regressors.hpp"

namespace orbident {

// df/dS, df/dP and df/dA of one body's columns.
struct ColumnGradients {
  Eigen::Matrix<double, 3, PER_BODY> S, P, A;
};

// Memory of one reverse pass; the caller's.
struct Wrenches {
  Motion<double>* turn;  // bodies; w the moment about S, u the force
  Motion<double>* rate;  // bodies
};

// The wrenches of one body.
inline void body_wrenches(const ColumnGradients& f, const Pose<double>& pose,
                          const Motion<double>& motion, Motion<double>& turn,
                          Motion<double>& rate) {
  // Where the entry (a, b) of the inertia stands in theta_i.
  constexpr int ENTRY[3][3] = {{4, 5, 7}, {5, 6, 8}, {7, 8, 9}};
  const Vector3<double>&d = pose.d, &w = motion.w;
  const Vector3<double> v = motion.u + w.cross(d), y = pose.R.transpose() * w;
  Vector3<double> f_d = f.S.col(0) + v.cross(f.A.col(0));
  Vector3<double> f_v = f.P.col(0) + f.A.col(0).cross(d);
  Vector3<double> f_w = Vector3<double>::Zero(), moment = Vector3<double>::Zero();
  for (int j = 0; j < 3; ++j) {
    const Vector3<double> r = pose.R.col(j), a = f.A.col(1 + j);
    // P: w x r, A: d x (w x r) + r x v, S: r.
    const Vector3<double> f_wr = f.P.col(1 + j) + a.cross(d);
    Vector3<double> f_r = f_wr.cross(w) + v.cross(a) + f.S.col(1 + j);
    f_w += r.cross(f_wr);
    f_d += w.cross(r).cross(a);
    f_v += a.cross(r);
    // A: sum_ab J_ab r_a y_b with y = R^T w.
    double f_y = 0.0;
    for (int b = 0; b < 3; ++b) {
      const Vector3<double> f_J = f.A.col(ENTRY[j][b]);
      f_r += f_J * y[b];
      f_y += f_J.dot(pose.R.col(b));
    }
    f_r += f_y * w;
    f_w += f_y * r;
    moment += r.cross(f_r);
  }
  // v = u + w x d.
  f_d += f_v.cross(w);
  turn = {moment + d.cross(f_d), f_d};
  rate = {f_w + d.cross(f_v), f_v};
}

// Adds df/dq and df/dqd, and returns df/dw; wrenches(i, turn, rate) gives those of body i.
template <class F>
Vector3<double> momentum_adjoint(const Tree& tree, const Motion<double>* field, const double* qd,
                                 F&& wrenches, Wrenches& at, double* f_q, double* f_qd) {
  for (int i = 0; i < tree.bodies(); ++i) wrenches(i, at.turn[i], at.rate[i]);
  for (int k = tree.joints - 1; k >= 0; --k) {
    const Motion<double>&S = field[k], &rate = at.rate[k + 1];
    Motion<double>& turn = at.turn[k + 1];
    turn.w += qd[k] * (S.w.cross(rate.w) + S.u.cross(rate.u));
    turn.u += qd[k] * S.w.cross(rate.u);
    f_q[k] += S.w.dot(turn.w) + S.u.dot(turn.u);
    f_qd[k] += S.w.dot(rate.w) + S.u.dot(rate.u);
    const int parent = tree.joint[k].parent;
    at.turn[parent].w += turn.w;
    at.turn[parent].u += turn.u;
    at.rate[parent].w += rate.w;
    at.rate[parent].u += rate.u;
  }
  return at.rate[0].w;
}

// The wrenches of a . h_rs + r . r_cm + v . p / M, with h_rs = h - s x p / M and r_cm = s / M, in
// terms of each body's first moment s, momentum p = m u + w x s and h = J w + s x u about S: to
// first order
//
//   S . s + P . p + a . h,   S = (a x p + r) / M,   P = (s x a + v) / M
//
// of the system.
struct MomentumGradients {
  Vector3<double> S, P, a;
  const Mass<double>* mass;
  const Motion<double>* motion;

  MomentumGradients(const Vector3<double>& a_, const Vector3<double>& r, const Vector3<double>& v,
                    const Mass<double>& all, const Vector3<double>& p, const Mass<double>* mass_,
                    const Motion<double>* motion_)
      : S((a_.cross(p) + r) / all.m),
        P((all.s.cross(a_) + v) / all.m),
        a(a_),
        mass(mass_),
        motion(motion_) {}
  void operator()(int i, Motion<double>& turn, Motion<double>& rate) const {
    const double m = mass[i].m;
    const Vector3<double>&s = mass[i].s, &w = motion[i].w, &u = motion[i].u;
    const Vector3<double> Jw = mass[i].J * w, Ja = mass[i].J * a, as = a.cross(s);
    const Vector3<double> f_s = S + P.cross(w) + u.cross(a);
    turn = {s.cross(f_s) + Jw.cross(a) + Ja.cross(w), m * f_s + w.cross(s).cross(a) + as.cross(w)};
    rate = {Ja + s.cross(P), m * P + as};
  }
};

// Adds X B^T for a sparse B.
template <class In>
void add_product_transposed(const In& X, const Sparse& B, Rows3<double>& result) {
  for (int c = 0; c < B.columns; ++c)
    for (int k = B.first[c]; k < B.first[c + 1]; ++k) result.col(B.row[k]) += X.col(c) * B.value[k];
}

// Memory for the gradient of the regressors; the caller's.
struct RegressorGradients {
  Rows3<double> S_sigma, P_sigma, f_S_sigma, f_P_sigma;  // 3 x phi
  Rows3<double> f_S, f_P, f_A;                           // 3 x theta

  ColumnGradients of(int i) const {
    return {f_S.middleCols<PER_BODY>(PER_BODY * i), f_P.middleCols<PER_BODY>(PER_BODY * i),
            f_A.middleCols<PER_BODY>(PER_BODY * i)};
  }
};

// From df/dY and df/dW to df/dS, df/dP and df/dA.
template <class Given>
void regressor_gradients(const MinimalSets& sets, const Rows3<double>& S, const Rows3<double>& P,
                         const Given& f_Y, const Given& f_W, RegressorGradients& at) {
  product<double>(S, sets.theta_of_sigma, at.S_sigma);
  product<double>(P, sets.theta_of_sigma, at.P_sigma);
  at.f_S_sigma.setZero();
  at.f_P_sigma = -f_W;
  for (int k = 0; k < sets.products; ++k) {
    const int a = sets.pair[2 * k], b = sets.pair[2 * k + 1];
    const Vector3<double> f = (a == b ? -0.5 : -1.0) * f_Y.col(sets.theta_of_linear.columns + k);
    const Vector3<double> S_a = at.S_sigma.col(a), S_b = at.S_sigma.col(b);
    const Vector3<double> P_a = at.P_sigma.col(a), P_b = at.P_sigma.col(b);
    at.f_S_sigma.col(a) += P_b.cross(f);
    at.f_P_sigma.col(b) += f.cross(S_a);
    at.f_S_sigma.col(b) += P_a.cross(f);
    at.f_P_sigma.col(a) += f.cross(S_b);
  }
  at.f_S.setZero();
  at.f_P.setZero();
  at.f_A.setZero();
  add_product_transposed(at.f_S_sigma, sets.theta_of_sigma, at.f_S);
  add_product_transposed(at.f_P_sigma, sets.theta_of_sigma, at.f_P);
  add_product_transposed(f_Y, sets.theta_of_linear, at.f_A);
}

}  // namespace orbident
