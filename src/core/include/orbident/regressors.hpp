// The regressors of the minimal sets: Y of Eq. 19 and W of Eq. 29.
//
//   h_rs = Y pi,   v_S - v_cm = W phi  (base axes)
//
// With L = theta_of_linear and G = theta_of_sigma, both sparse,
//
//   Y = [A L | -(S_a x P_b + S_b x P_a)],  S_a = S G_a,  P_a = P G_a,  halved where a = b
//   W = -P G
#pragma once

#include "orbident/momentum.hpp"

namespace orbident {

// A sparse matrix by columns: column c has the entries first[c] .. first[c + 1].
struct Sparse {
  const int* first;
  const int* row;
  const Real* value;
  int columns;
};

// What Y and W need of a robot beside its tree; views of constant tables.
struct MinimalSets {
  Sparse theta_of_linear;
  Sparse theta_of_sigma;
  const int* pair;  // products x 2: which of sigma are multiplied
  int products;
  constexpr int pis() const { return theta_of_linear.columns + products; }
  constexpr int phis() const { return theta_of_sigma.columns; }
};

// X B for a sparse B.
template <class T, class In, class Result>
void product(const In& X, const Sparse& B, Result&& result) {
  for (int c = 0; c < B.columns; ++c) {
    Vector3<T> sum = Vector3<T>::Zero();
    for (int k = B.first[c]; k < B.first[c + 1]; ++k) sum += X.col(B.row[k]) * T(B.value[k]);
    result.col(c) = sum;
  }
}

// Y (3 x pi) and W (3 x phi) from S, P and A; S_sigma (3 x phi) is the caller's memory.
template <class T>
void regressors(const MinimalSets& sets, const Rows3<T>& S, const Rows3<T>& P, const Rows3<T>& A,
                Rows3<T> S_sigma, Rows3<T> Y, Rows3<T> W) {
  product<T>(S, sets.theta_of_sigma, S_sigma);
  product<T>(P, sets.theta_of_sigma, W);
  product<T>(A, sets.theta_of_linear, Y);
  for (int k = 0; k < sets.products; ++k) {
    const int a = sets.pair[2 * k], b = sets.pair[2 * k + 1];
    const Vector3<T> S_a = S_sigma.col(a), S_b = S_sigma.col(b), P_a = W.col(a), P_b = W.col(b);
    const Vector3<T> sum = S_a.cross(P_b) + S_b.cross(P_a);
    Y.col(sets.theta_of_linear.columns + k) = (a == b ? T(-0.5) : T(-1)) * sum;
  }
  W = -W;
}

}  // namespace orbident
