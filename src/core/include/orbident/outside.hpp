// The motion of the system CM where nothing acts from outside; inertial axes.
//
//   h_cm(t) = h_cm
//   r_cm(t) = r_cm + t v_cm
#pragma once

#include "orbident/rotations.hpp"

namespace orbident {

// The unknowns, three numbers each, in this order.
enum Conserved { MOMENTUM, VELOCITY, POSITION, CONSERVED };
constexpr int OUTSIDE = 3 * CONSERVED;

// What each unknown contributes by being one, at the time t (s) since the first row.
template <class T>
struct Contributions {
  T h_cm[CONSERVED];
  T r_cm[CONSERVED];
  T v_cm[CONSERVED];
};

template <class T>
Contributions<T> contributions(const T& t) {
  return {{T(1), T(0), T(0)}, {T(0), t, T(1)}, {T(0), T(1), T(0)}};
}

// The sum of all contributions to one of these vectors.
template <class T>
Vector3<T> contributed(const T* parts, const T* outside) {
  Vector3<T> sum = Vector3<T>::Zero();
  for (int k = 0; k < CONSERVED; ++k)
    sum += parts[k] * Eigen::Map<const Vector3<T>>(outside + 3 * k);
  return sum;
}

}  // namespace orbident
