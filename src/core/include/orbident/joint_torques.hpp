// Torques that sensors at joints show, over a shooting interval (joint_momenta.hpp).
//
// A torque t of joint k, less what friction and the motor's rotor take of it, changes its momentum:
//
//   d(p + A qd)/dt = e + t - d qd - c sign(qd) - o       so that with  P = p + A qd + d q
//   mean of t = ([P] - int e dt) / T + c mean of sign(qd) + o
//
// over an interval of T s, where A = N (N - 1) J is what the rotor's energy has beside that of
// bodies with the same momentum. No acceleration is needed: [P] is of the interval's ends, and e is
// integrated by Simpson's rule over each row, its middle and the next one. A sensor shows
// 1 + g times the torque, as late as the joints are shown: by l (t(T) - t(0)) / T less.
#pragma once

#include "orbident/passive_rates.hpp"

namespace orbident {

inline void start_torques(const Recorded& recorded, PassiveMemory& own) {
  const int K = recorded.tree.joints;
  std::fill_n(own.impulse, K, 0.0);
  std::fill_n(own.impulse_by, K * recorded.columns.count(), 0.0);
}

// Takes the momentum `on_p` times and the slope of the energy `on_e` times, at a node.
inline void add_joint_torques(const Recorded& recorded, const LinearisedAt& at,
                              const JointNode& joints, const BaseNode& base, double on_p,
                              double on_e, PassiveMemory& own) {
  const int K = recorded.tree.joints, n = recorded.columns.count(), all = own.places.count();
  const CalibrationPlaces& places = at.calibration.places;
  pose_and_weigh(recorded.tree, at.theta, joints.q, own.at.bodies);
  joint_momenta(recorded.tree, joints.qd, base.w, own.at);
  for (int g = 0; g < own.places.geometries; ++g)
    own.geometry[g] = displacement(recorded.tree, at.calibration, own.at.bodies.pose, own.place[g]);
  differentiate_joint_momenta(recorded.tree, recorded.theta_of, own.places, own.geometry,
                              own.displaced, own.at);
  const TableRows dw(base.dw, 3, n);
  for (int k = 0; k < K; ++k) {
    const Drive drive(recorded, at.calibration, k);
    double *p = own.at.slopes + (3 + k) * all, *e = p + K * all, *to = own.impulse_by + k * n;
    own.impulse[k] += on_p * (own.at.values[3 + k] + drive.armature * joints.qd[k] +
                              drive.viscous * joints.q[k]) +
                      on_e * own.at.values[3 + K + k];
    for (int c = 0; c < all; ++c) p[c] = on_p * p[c] + on_e * e[c];
    p[own.places.qd() + k] += on_p * drive.armature;
    p[own.places.q() + k] += on_p * drive.viscous;
    write_known(recorded, at, own.places, joints, p, own.row);
    for (int c = 0; c < n; ++c)
      to[c] += own.row[c] + p[0] * dw(0, c) + p[1] * dw(1, c) + p[2] * dw(2, c);
    for (int i = 0; i < recorded.springs; ++i) {
      const int joint = recorded.spring[i].joint;
      const double *s = base.phi + (3 + i) * n, *dy = base.dw + (3 + i) * n;
      for (int c = 0; c < n; ++c)
        to[c] += p[own.places.q() + joint] * s[c] + p[own.places.qd() + joint] * dy[c];
    }
    for (int c = 0; c < recorded.columns.calibrations; ++c) {
      double& entry = to[recorded.columns.calibration() + c];
      const int at_place = at.calibration.selected[c];
      if (at_place == places.armature() + k) entry += on_p * joints.qd[k];
      if (at_place == places.viscous() + k) entry += on_p * joints.q[k];
    }
  }
}

// The rows of an interval whose sums are complete.
inline void add_torques(const Recorded& recorded, const LinearisedAt& at, int interval,
                        double duration, PassiveMemory& own, EquationTable& equations) {
  const IntervalColumns& columns = recorded.columns;
  const int K = recorded.tree.joints, n = columns.count();
  const CalibrationPlaces& places = at.calibration.places;
  for (int k = 0; k < K; ++k) {
    const int sample = recorded.edge[interval] * K + k;
    const double weight = recorded.torques.weights[sample];
    if (weight == 0.0) continue;
    const Drive drive(recorded, at.calibration, k);
    const double* over = recorded.over_intervals + 2 * (interval * K + k);
    const double rubbed = over[0], changed = over[1], gain = 1 + drive.scale;
    double* by = own.impulse_by + k * n;
    const double mean = own.impulse[k] / duration + drive.coulomb * rubbed + drive.offset;
    for (int c = 0; c < n; ++c) by[c] *= gain / duration;
    for (int c = 0; c < columns.calibrations; ++c) {
      double& entry = by[columns.calibration() + c];
      const int at_place = at.calibration.selected[c];
      if (at_place == places.torque_scale() + k) entry += mean;
      if (at_place == places.coulomb() + k) entry += gain * rubbed;
      if (at_place == places.offset() + k) entry += gain;
      if (at_place == places.joint_clock()) entry -= changed;
    }
    const double late = at.calibration.values[places.joint_clock()];
    const double error = recorded.torques.values[sample] + late * changed - gain * mean;
    recorded.torques.keep(sample, weight * error);
    equations.add(columns, by, weight, error);
  }
}

}  // namespace orbident
