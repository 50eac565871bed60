// Attitude from a gyro, and from a gyro and attitude fixes together.
//
// The gyro alone, by the fourth-order Magnus expansion (Iserles et al. 2000) from one row to the
// next, with w_1, w_2 the rate at the two Gauss points of the step h:
//
//   x(t + h) = x(t) (x) exp(h/2 (w_1 + w_2) + sqrt(3)/12 h^2 w_1 x w_2)
//
// Fixes correct what the gyro got wrong: a small rotation phi about inertial axes and its bias b,
//
//   phi+ = phi - B b + N(0, Q_phi),  b+ = b + N(0, Q_b),  fix: y = phi + N(0, R),
//
// by a Kalman filter and smoother (Rauch, Tung, Striebel 1965).
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "orbident/rotations.hpp"

namespace orbident {

// x followed by the rotation r, in the axes that x turns.
template <class T>
Quaternion<T> turned(const Quaternion<T>& x, const Vector3<T>& r) {
  using std::cos;
  using std::sin;
  const T angle = r.norm(), half = angle / T(2);
  const Vector3<T> v = (angle > T(0) ? sin(half) / angle : T(0.5)) * r;
  // quaternion_rate(x, 2 v) is the product of x and (v, 0).
  return (cos(half) * x + quaternion_rate<T>(x, T(2) * v)).normalized();
}

template <class T>
Vector3<T> magnus_rotation(const T& h, const Vector3<T>& w_1, const Vector3<T>& w_2) {
  using std::sqrt;
  return h / T(2) * (w_1 + w_2) + sqrt(T(3)) / T(12) * h * h * w_1.cross(w_2);
}

template <class T>
using Vector6 = Eigen::Matrix<T, 6, 1>;
template <class T>
using Matrix6 = Eigen::Matrix<T, 6, 6>;

// What is known of [phi, b]: mean and covariance.
template <class T>
struct GyroError {
  Vector6<T> mean;
  Matrix6<T> covariance;
};

// From one row to the next.
template <class T>
struct GyroStep {
  Matrix3<T> B;
  // Of phi and of b, about each axis.
  T Q_phi, Q_b;

  Matrix6<T> F() const {
    Matrix6<T> F = Matrix6<T>::Identity();
    F.template topRightCorner<3, 3>() = -B;
    return F;
  }
};

template <class T>
GyroError<T> predicted(const GyroStep<T>& step, const GyroError<T>& known) {
  const Matrix6<T> F = step.F();
  GyroError<T> next{F * known.mean, F * known.covariance * F.transpose()};
  next.covariance.diagonal().template head<3>().array() += step.Q_phi;
  next.covariance.diagonal().template tail<3>().array() += step.Q_b;
  return next;
}

// Takes in a fix of variance R.
template <class T>
void correct(const Vector3<T>& y, const T& R, GyroError<T>& known) {
  const Matrix6<T>& P = known.covariance;
  const Matrix3<T> S = P.template topLeftCorner<3, 3>() + R * Matrix3<T>::Identity();
  const Eigen::Matrix<T, 6, 3> K = P.template leftCols<3>() * S.inverse();
  known.mean += (K * (y - known.mean.template head<3>())).eval();
  // Joseph: P stays symmetric and positive.
  Matrix6<T> A = Matrix6<T>::Identity();
  A.template leftCols<3>() -= K;
  known.covariance = (A * P * A.transpose() + R * K * K.transpose()).eval();
}

// The error at a row, given all fixes: from what the filter knew there, and the smoothed error
// `next` at the row after.
template <class T>
GyroError<T> smoothed(const GyroError<T>& filtered, const GyroStep<T>& step,
                      const GyroError<T>& next) {
  const GyroError<T> ahead = predicted(step, filtered);
  const Matrix6<T> C = ahead.covariance.ldlt().solve(step.F() * filtered.covariance).transpose();
  const Matrix6<T> P =
      filtered.covariance + C * (next.covariance - ahead.covariance) * C.transpose();
  return {filtered.mean + C * (next.mean - ahead.mean), (P + P.transpose()) / T(2)};
}

}  // namespace orbident
