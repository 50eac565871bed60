// Calibration errors of the instruments, common to a whole recording; zero where they are perfect:
//
//   joints          q = (1 + s_k) q_shown + z_k,   rates and accelerations (1 + s_k) times theirs
//   geometry        joint k is at p_PJ + d_k, parent's axes, its axes turned there by R(r_k)
//   wheels          h_rw = sum_i (1 + g_i) R(r_i) a_i I_i qd_i
//   feature point   the tracked point is S + d, base axes
//   attitude        shown R_WB R(m)
//   gyro            shown (1 + diag(s)) R(m)^T w + bias
//   position        shown (1 + p) times the position
//   clocks          what joints and wheels, the attitude sensor or the tracker show is l old: to
//                   first order in l, q = q_shown + l qd_shown, and what is shown is x - l x'
//   springs         those of passive_rates.hpp: logarithms of their rate and their damping
//   torques         those of joint_torques.hpp: scale g, rotor A, friction d, c and o of each joint
//
// m turns the base's axes into the instrument's: a vector along the axis, of length
// 2 sin(angle / 2), as r is.
//
// A motion has columns of the calibrations that are selected, by their places among all:
//
//   [z, each joint | s, each joint | g, each wheel | r 3, each wheel | d 3 | attitude m 3 |
//    gyro m 3 | gyro s 3 | p | l of joints, of attitude, of position | d 3, each joint |
//    r 3, each joint | x, each joint | y, each joint | g | A | d | c | o, each joint]
//
// Places beyond these are gains of what acts from outside (acting.hpp).
#pragma once

#include "orbident/sensors.hpp"

namespace orbident {

struct CalibrationPlaces {
  int joints, wheels;
  int zero() const { return 0; }
  int scale() const { return joints; }
  int wheel() const { return 2 * joints; }
  int wheel_axis() const { return wheel() + wheels; }
  int feature_point() const { return wheel_axis() + 3 * wheels; }
  int attitude() const { return feature_point() + 3; }
  int gyro() const { return attitude() + 3; }
  int gyro_scale() const { return gyro() + 3; }
  int position() const { return gyro_scale() + 3; }
  int joint_clock() const { return position() + 1; }
  int attitude_clock() const { return joint_clock() + 1; }
  int position_clock() const { return attitude_clock() + 1; }
  int place() const { return position_clock() + 1; }
  int direction() const { return place() + 3 * joints; }
  bool is_geometry(int at) const { return place() <= at && at < spring(); }
  int spring() const { return direction() + 3 * joints; }
  int damper() const { return spring() + joints; }
  int torque_scale() const { return damper() + joints; }
  int armature() const { return torque_scale() + joints; }
  int viscous() const { return armature() + joints; }
  int coulomb() const { return viscous() + joints; }
  int offset() const { return coulomb() + joints; }
  int count() const { return offset() + joints; }
};

// Which calibrations have columns, and the values of all.
struct Calibration {
  CalibrationPlaces places;
  const int* selected;
  const double* values;

  Vector3<double> vector(int place) const {
    return Eigen::Map<const Vector3<double>>(values + place);
  }
};

// The quaternion of a rotation m, and the rate of its rotation (axes after it) by m.
struct Misalignment {
  Quaternion<double> x;
  Matrix3<double> R;
  Matrix3<double> by_m;

  explicit Misalignment(const Vector3<double>& m) {
    const Vector3<double> v = m / 2;
    const double s = std::sqrt(1.0 - v.squaredNorm());
    x << v, s;
    R = quaternion_matrix(x);
    by_m = s * Matrix3<double>::Identity() + v * v.transpose() / s - cross_matrix(v);
  }
};

// A joint elsewhere, by d and r, parent's axes.
inline void shift(Joint& joint, const Vector3<double>& d, const Vector3<double>& r) {
  const Matrix3<double> R = Misalignment(r).R;
  joint.p_PJ += d;
  joint.axis = R * joint.axis;
  for (Matrix3<double>* part : {&joint.fixed, &joint.cosine, &joint.sine}) *part = R * *part;
}

// The field along which joint k and what it carries is displaced by one of its d and r.
inline Motion<double> displacement(const Tree& tree, const Calibration& calibration,
                                   const Pose<double>* pose, int place) {
  const CalibrationPlaces& places = calibration.places;
  const bool turns = place >= places.direction();
  const int first = turns ? places.direction() : places.place();
  const int k = (place - first) / 3, axis = (place - first) % 3;
  const Joint& joint = tree.joint[k];
  const Pose<double>& parent = pose[joint.parent];
  if (!turns) return {Vector3<double>::Zero(), parent.R.col(axis)};
  const Misalignment r(calibration.vector(first + 3 * k));
  const Vector3<double> w = parent.R * (r.R * r.by_m.col(axis));
  const Vector3<double> at = parent.d + parent.R * joint.p_PJ;
  return {w, at.cross(w)};
}

// Every column of a table times a matrix, in place.
inline void transform(const Matrix3<double>& by, int count, double* slopes) {
  CombinedRows(slopes, count).add(by - Matrix3<double>::Identity(), slopes);
}

// Adds the columns of the selected ones among the places from `first` on, given those of all of
// them.
template <class By>
void add_selected(const IntervalColumns& columns, const Calibration& calibration, int first,
                  const By& by, double* slopes) {
  const int n = columns.count();
  for (int c = 0; c < columns.calibrations; ++c) {
    const int k = calibration.selected[c] - first;
    if (k < 0 || k >= by.cols()) continue;
    for (int r = 0; r < by.rows(); ++r) slopes[r * n + columns.calibration() + c] += by(r, k);
  }
}

// Adds what a joint's change by x, and of its rate by v, does to the terms.
inline void add_joint(const TermsMemory& memory, int k, double x, double v, double* column,
                      std::ptrdiff_t stride) {
  const MomentumTerms &by_q = memory.by_q[k], &by_qd = memory.by_qd[k];
  double change[BY_ROWS];
  write_change(
      {x * by_q.D, x * by_q.h_q + v * by_qd.h_q, x * by_q.r_cm, x * by_q.v_q + v * by_qd.v_q},
      change, 1);
  for (int r = 0; r < BY_ROWS; ++r) column[r * stride] += change[r];
}

// The momentum of wheel i for each of its rates, R(r_i) a_i I_i, of a_i I_i in A_rw.
inline Vector3<double> momentum_of_wheel(const Calibration& calibration, const double* A_rw,
                                         int i) {
  const Misalignment r(calibration.vector(calibration.places.wheel_axis() + 3 * i));
  return r.R * Eigen::Map<const Vector3<double>>(A_rw + 3 * i);
}

// The change of the wheels' momentum with one calibration: their inertia, axes and clock.
inline Vector3<double> by_wheels(const Calibration& calibration, const JointState& shown,
                                 const double* A_rw, int place) {
  const CalibrationPlaces& places = calibration.places;
  Vector3<double> change = Vector3<double>::Zero();
  if (place == places.joint_clock()) {
    for (int i = 0; i < places.wheels; ++i)
      change += shown.qdd_rw[i] * momentum_of_wheel(calibration, A_rw, i);
  } else if (places.wheel() <= place && place < places.wheel_axis()) {
    const int i = place - places.wheel();
    change = shown.qd_rw[i] * momentum_of_wheel(calibration, A_rw, i);
  } else if (places.wheel_axis() <= place && place < places.feature_point()) {
    const int i = (place - places.wheel_axis()) / 3, axis = (place - places.wheel_axis()) % 3;
    const double gain = 1 + calibration.values[places.wheel() + i];
    const double late = calibration.values[places.joint_clock()];
    const Misalignment r(calibration.vector(places.wheel_axis() + 3 * i));
    const Vector3<double> w = r.R * r.by_m.col(axis);
    change = (gain * shown.qd_rw[i] + late * shown.qdd_rw[i]) *
             w.cross(momentum_of_wheel(calibration, A_rw, i));
  }
  return change;
}

// Changes of the terms at a node with zeros, scales, clock and geometry of joints, and with the
// wheels' momentum.
inline void write_calibrations(const Tree& tree, const IntervalColumns& columns,
                               const Calibration& calibration, const JointState& shown,
                               const double* A_rw, const TermsMemory& memory, double* by) {
  const CalibrationPlaces& places = calibration.places;
  const int n = columns.count();
  for (int c = 0; c < columns.calibrations; ++c) {
    double* column = by + columns.calibration() + c;
    const int place = calibration.selected[c];
    for (int r = 0; r < BY_ROWS; ++r) column[r * n] = 0.0;
    if (place >= places.spring()) continue;
    if (place >= places.place()) {
      const int k = (place - places.place()) / 3 % places.joints;
      write_change(
          displaced(tree, memory, k, displacement(tree, calibration, memory.at.pose, place)),
          column, n);
    } else if (place == places.joint_clock()) {
      for (int k = 0; k < places.joints; ++k)
        add_joint(memory, k, shown.qd[k], shown.qdd[k], column, n);
    } else if (place < places.wheel()) {
      const bool zero = place < places.scale();
      const int k = place - (zero ? places.zero() : places.scale());
      add_joint(memory, k, zero ? 1.0 : shown.q[k], zero ? 0.0 : shown.qd[k], column, n);
    }
    const Vector3<double> dh_rw = by_wheels(calibration, shown, A_rw, place);
    for (int axis = 0; axis < 3; ++axis) column[(BY_H + axis) * n] += dh_rw[axis];
  }
}

// The predictions of the base's sensors as badly calibrated instruments show them, and their
// slopes, in place from those of perfect instruments.

inline void calibrate_gyro(const IntervalColumns& columns, const Calibration& calibration,
                           Vector3<double>& shown, double* slopes) {
  const CalibrationPlaces& places = calibration.places;
  const Misalignment m(calibration.vector(places.gyro()));
  const Vector3<double> sensed = m.R.transpose() * shown;
  const Vector3<double> gain = calibration.vector(places.gyro_scale()) + Vector3<double>::Ones();
  shown = gain.cwiseProduct(sensed);
  transform(gain.asDiagonal() * m.R.transpose(), columns.count(), slopes);
  add_selected(columns, calibration, places.gyro(),
               Matrix3<double>(gain.asDiagonal() * cross_matrix(sensed) * m.by_m), slopes);
  add_selected(columns, calibration, places.gyro_scale(), Matrix3<double>(sensed.asDiagonal()),
               slopes);
}

inline void calibrate_attitude(const IntervalColumns& columns, const Calibration& calibration,
                               const BaseNode& base, Quaternion<double>& shown, double* slopes) {
  const CalibrationPlaces& places = calibration.places;
  const int place = places.attitude(), clock = places.attitude_clock();
  const double l = calibration.values[clock];
  const Misalignment old(Vector3<double>(-l * base.w));
  const Misalignment m(calibration.vector(place));
  shown = composed(Quaternion<double>(composed(shown, old.x)), m.x);
  const Matrix3<double> by_w = m.R.transpose() * old.by_m;
  const int n = columns.count();
  transform((old.R * m.R).transpose(), n, slopes);
  if (l != 0.0) CombinedRows(slopes, n).add(-l * by_w, base.dw);
  add_selected(columns, calibration, place, m.by_m, slopes);
  add_selected(columns, calibration, clock, Vector3<double>(-(by_w * base.w)), slopes);
}

// by_v: slopes of the velocity relative to the CM.
inline void calibrate_position(const IntervalColumns& columns, const Calibration& calibration,
                               const JointNode& joints, const BaseNode& base, const double* outside,
                               const double* by_v, Vector3<double>& shown, double* slopes) {
  const CalibrationPlaces& places = calibration.places;
  const Vector3<double> d = calibration.vector(places.feature_point());
  const double gain = 1.0 + calibration.values[places.position()];
  const int clock = places.position_clock(), n = columns.count();
  const double l = calibration.values[clock];
  const Vector3<double> v = velocity(joints, base, outside);
  const Vector3<double> tracked = shown + base.R_WB * d - l * v;
  shown = gain * tracked;
  TableRows table(slopes, 3, n);
  if (l != 0.0) {
    Contributions parts = contributions(joints.t);
    for (double& part : parts.v_cm) part *= -l;
    add_outside(columns, parts.v_cm, table);
    joints.acting.add(ON_V, Matrix3<double>(-l * Matrix3<double>::Identity()), table);
    table -= l * ConstTableRows(by_v, 3, n);
  }
  table *= gain;
  CombinedRows(slopes, n).add(-gain * base.R_WB * cross_matrix(d), base.phi);
  add_selected(columns, calibration, places.feature_point(), Matrix3<double>(gain * base.R_WB),
               slopes);
  add_selected(columns, calibration, places.position(), tracked, slopes);
  add_selected(columns, calibration, clock, Vector3<double>(-gain * v), slopes);
}

// A tracker is late for both, v - l a: these are the slopes without those of a.
inline void calibrate_velocity(const IntervalColumns& columns, const Calibration& calibration,
                               const BaseNode& base, const Vector3<double>& a,
                               Vector3<double>& shown, double* slopes) {
  const int place = calibration.places.feature_point(), n = columns.count();
  const int clock = calibration.places.position_clock();
  const Vector3<double> d = calibration.vector(place), u = base.w.cross(d);
  const Matrix3<double>& R = base.R_WB;
  shown += R * u - calibration.values[clock] * a;
  CombinedRows(slopes, n).add(-R * cross_matrix(u), base.phi).add(-R * cross_matrix(d), base.dw);
  add_selected(columns, calibration, place, Matrix3<double>(R * cross_matrix(base.w)), slopes);
  add_selected(columns, calibration, clock, Vector3<double>(-a), slopes);
}

}  // namespace orbident
