// The momentum of one sample, linear in theta (Eqs. 3 and 19).
//
//   S theta = sum_i  m_i d_i + R_i s_i                          first moment about S
//   P theta = sum_i  m_i v_i + w_i x R_i s_i                    linear momentum relative to S
//   A theta = sum_i  d_i x (m_i v_i + w_i x R_i s_i)            angular momentum about S
//                    + R_i s_i x v_i + R_i J_i R_i^T w_i
//
// with v_i = u_i + w_i x d_i. The angular momentum about the system CM is
// h_rs = A theta - (S theta) x (P theta) / M. Base axes; theta_i = [m, m c, Jxx, Jxy, Jyy, Jxz,
// Jyz, Jzz] about the body's origin, body axes.
//
// The columns of S and P for second moments are zero in every sample and not written: the caller's
// memory is zero before the first one.
#pragma once

#include "orbident/tree.hpp"

namespace orbident {

constexpr int PER_BODY = 10;

template <class T>
using Rows3 = Eigen::Map<Eigen::Matrix<T, 3, Eigen::Dynamic, Eigen::RowMajor>>;

template <class T>
void first_moment_columns(const Tree& tree, const Pose<T>* pose, Rows3<T> S) {
  for (int i = 0; i < tree.bodies(); ++i) {
    S.col(PER_BODY * i) = pose[i].d;
    S.template middleCols<3>(PER_BODY * i + 1) = pose[i].R;
  }
}

template <class T>
void momentum_columns(const Tree& tree, const Pose<T>* pose, const Motion<T>* motion, Rows3<T> P,
                      Rows3<T> A) {
  for (int i = 0; i < tree.bodies(); ++i) {
    const Matrix3<T>& R = pose[i].R;
    const Vector3<T>& d = pose[i].d;
    const Vector3<T>& w = motion[i].w;
    const Vector3<T> v = motion[i].u + w.cross(d);
    auto P_i = P.template middleCols<PER_BODY>(PER_BODY * i);
    auto A_i = A.template middleCols<PER_BODY>(PER_BODY * i);
    P_i.col(0) = v;
    A_i.col(0) = d.cross(v);
    for (int j = 0; j < 3; ++j) {
      const Vector3<T> r = R.col(j);
      const Vector3<T> wr = w.cross(r);
      P_i.col(1 + j) = wr;
      A_i.col(1 + j) = d.cross(wr) + r.cross(v);
    }
    // R L(R^T w), with J w = L(w) [Jxx, Jxy, Jyy, Jxz, Jyz, Jzz].
    const Vector3<T> y = R.transpose() * w;
    A_i.col(4) = R.col(0) * y[0];
    A_i.col(5) = R.col(0) * y[1] + R.col(1) * y[0];
    A_i.col(6) = R.col(1) * y[1];
    A_i.col(7) = R.col(0) * y[2] + R.col(2) * y[0];
    A_i.col(8) = R.col(1) * y[2] + R.col(2) * y[1];
    A_i.col(9) = R.col(2) * y[2];
  }
}

}  // namespace orbident
