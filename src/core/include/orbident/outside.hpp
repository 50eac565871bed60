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
struct Contributions {
  double h_cm[CONSERVED];
  double r_cm[CONSERVED];
  double v_cm[CONSERVED];
};

inline Contributions contributions(double t) {
  return {{1.0, 0.0, 0.0}, {0.0, t, 1.0}, {0.0, 1.0, 0.0}};
}

// The sum of all contributions to one of these vectors.
inline Vector3<double> contributed(const double* parts, const double* outside) {
  Vector3<double> sum = Vector3<double>::Zero();
  for (int k = 0; k < CONSERVED; ++k)
    sum += parts[k] * Eigen::Map<const Vector3<double>>(outside + 3 * k);
  return sum;
}

}  // namespace orbident
