// What acts from outside, and the motion of the system CM that it leaves; inertial axes.
//
//   h_cm(t) = h_cm + t torque
//   r_cm(t) = r_cm + t v_cm + t^2/2 pull
//
// Every disturbance is a vector of this list and a column of these equations; nothing else in the
// core knows which there are.
#pragma once

#include "orbident/rotations.hpp"

namespace orbident {

// The unknowns, three numbers each, in this order.
enum Disturbance { MOMENTUM, VELOCITY, POSITION, TORQUE, PULL, DISTURBANCES };
constexpr int OUTSIDE = 3 * DISTURBANCES;

// What each unknown contributes by being one, at the time t (s) since the first row.
template <class T>
struct Contributions {
  T h_cm[DISTURBANCES];
  T h_cm_rate[DISTURBANCES];
  T r_cm[DISTURBANCES];
  T v_cm[DISTURBANCES];
};

template <class T>
Contributions<T> contributions(const T& t) {
  return {{T(1), T(0), T(0), t, T(0)},
          {T(0), T(0), T(0), T(1), T(0)},
          {T(0), t, T(1), T(0), t * t / T(2)},
          {T(0), T(1), T(0), T(0), t}};
}

// The sum of all contributions to one of these vectors.
template <class T>
Vector3<T> contributed(const T* parts, const T* outside) {
  Vector3<T> sum = Vector3<T>::Zero();
  for (int k = 0; k < DISTURBANCES; ++k)
    sum += parts[k] * Eigen::Map<const Vector3<T>>(outside + 3 * k);
  return sum;
}

}  // namespace orbident
