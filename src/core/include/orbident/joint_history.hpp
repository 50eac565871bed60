// What joints and wheels did along a recording: cubic splines through their samples, a column each.
//
// Between two knots a column is the cubic with its values and slopes at both.
#pragma once

#include <algorithm>

#include "orbident/interval_cubics.hpp"

namespace orbident {

// A joint and a wheel at one time; what is not filled in is absent.
struct JointState {
  double *q, *qd, *qdd;    // joints each
  double *qd_rw, *qdd_rw;  // wheels each
};

struct JointHistory {
  int knots;
  const double* t;  // of the knots, s
  // By column, a number each knot: values, and slopes of the spline through them.
  const double *const *q, *const *q_slope, *const *qd, *const *qdd;  // joints
  const double *const *qd_rw, *const *qdd_rw;                        // wheels

  // The knot at or before a time, looked for first where the last one was.
  int knot(double at, int last) const {
    constexpr int NEAR = 8;
    const bool near = last + NEAR < knots && t[last] <= at && at < t[last + NEAR];
    const double* const from = near ? t + last : t;
    const double* const after = std::upper_bound(from, near ? from + NEAR : t + knots, at);
    return std::clamp(static_cast<int>(after - t) - 1, 0, knots - 2);
  }

  Cubics functions(double at, int knot) const {
    return cubics(at - t[knot], t[knot + 1] - t[knot]);
  }

  static double between(const double* f, const double* value, const double* slope, int knot) {
    return f[0] * value[knot] + f[1] * slope[knot] + f[2] * value[knot + 1] +
           f[3] * slope[knot + 1];
  }

  // Everything at a time; returns the knot.
  int state(double at, int last, int joints, int wheels, const JointState& to) const {
    const int k = knot(at, last);
    const Cubics f = functions(at, k);
    for (int j = 0; j < joints; ++j) {
      to.q[j] = between(f.value, q[j], q_slope[j], k);
      to.qd[j] = between(f.value, qd[j], qdd[j], k);
      to.qdd[j] = between(f.rate, qd[j], qdd[j], k);
    }
    for (int i = 0; i < wheels; ++i) {
      to.qd_rw[i] = between(f.value, qd_rw[i], qdd_rw[i], k);
      to.qdd_rw[i] = between(f.rate, qd_rw[i], qdd_rw[i], k);
    }
    return k;
  }
};

}  // namespace orbident
