// Vectors, rotations and quaternions. A quaternion is [x, y, z, w], Hamilton, and rotates base
// vectors into inertial axes: R_WB(x_WB).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace orbident {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;
template <class T>
using Quaternion = Eigen::Matrix<T, 4, 1>;

// [v]x, so that [v]x u = v x u.
template <class T>
Matrix3<T> cross_matrix(const Vector3<T>& v) {
  Matrix3<T> m;
  m << T(0), -v.z(), v.y(), v.z(), T(0), -v.x(), -v.y(), v.x(), T(0);
  return m;
}

// R_WB of a quaternion of any nonzero norm: dividing by the squared norm makes it orthogonal.
template <class T>
Matrix3<T> quaternion_matrix(const Quaternion<T>& x_WB) {
  const T x = x_WB[0], y = x_WB[1], z = x_WB[2], w = x_WB[3];
  const T s = T(2) / (x * x + y * y + z * z + w * w);
  Matrix3<T> R;
  R << T(1) - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),  //
      s * (x * y + z * w), T(1) - s * (x * x + z * z), s * (y * z - x * w),   //
      s * (x * z - y * w), s * (y * z + x * w), T(1) - s * (x * x + y * y);
  return R;
}

// R_WB^T v, of a quaternion of any nonzero norm.
template <class T>
Vector3<T> rotate_back(const Quaternion<T>& x_WB, const Vector3<T>& v) {
  const Vector3<T> a = x_WB.template head<3>(), t = a.cross(v);
  return v + T(2) / x_WB.squaredNorm() * (a.cross(t) - x_WB[3] * t);
}

// d/dt x_WB = 1/2 x_WB (w, 0), with w the rate of B in W, base axes, rad/s.
template <class T>
Quaternion<T> quaternion_rate(const Quaternion<T>& x_WB, const Vector3<T>& w_WB_B) {
  const Vector3<T> v = x_WB.template head<3>();
  Quaternion<T> rate;
  rate.template head<3>() = T(0.5) * (x_WB[3] * w_WB_B + v.cross(w_WB_B));
  rate[3] = T(-0.5) * v.dot(w_WB_B);
  return rate;
}

// x_WC = x_WB x_BC.
template <class T>
Quaternion<T> composed(const Quaternion<T>& x_WB, const Quaternion<T>& x_BC) {
  const Vector3<T> a = x_WB.template head<3>(), b = x_BC.template head<3>();
  Quaternion<T> x_WC;
  x_WC.template head<3>() = x_WB[3] * b + x_BC[3] * a + a.cross(b);
  x_WC[3] = x_WB[3] * x_BC[3] - a.dot(b);
  return x_WC;
}

// The rotation vector from A to B, A's axes, rad; for a large angle a it has length 2 sin(a/2).
template <class T>
Vector3<T> small_rotation(const Quaternion<T>& x_WA, const Quaternion<T>& x_WB) {
  const Vector3<T> a = x_WA.template head<3>(), b = x_WB.template head<3>();
  const Vector3<T> v = x_WA[3] * b - x_WB[3] * a - a.cross(b);
  return (x_WA.dot(x_WB) < T(0) ? T(-2) : T(2)) * v;
}

}  // namespace orbident
