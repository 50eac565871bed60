// The equations of one shooting interval, linear in changes of the unknowns, whitened:
//
//   what the sensors showed - what is predicted = slopes x change
//   attitude and biases at the end = those at the next interval's start     (random walk)
//   lasting noise at the end = that at the next interval's start            (lasting_noise.hpp)
//   corrections of the joints at the end = 0                                (prior)
//   passive joints at the end = at the next interval's start                (passive_joints.hpp)
//   what torques of joints add up to = what their momenta did               (joint_torques.hpp)
//
// Unknowns, z of a boundary and g common to all, and the columns of a table:
//
//   z       turn 3 | gyro bias 3 | accelerometer bias 3 | lasting noise of attitude and position,
//           axis by axis; a momentum that walks | corrections: values, rates
//   g       outside | beta | calibration
//   table   z near | z far | g | right-hand side
//
// near is the boundary that is eliminated, the start or the end.
#pragma once

#include "orbident/joint_torques.hpp"
#include "orbident/lasting_noise.hpp"
#include "orbident/passive_joints.hpp"

namespace orbident {

// The rows of a sensor with three axes; `bias` is where its bias is in z, or -1.
inline void add_sample(const IntervalColumns& c, const Sensed& sensor, int row,
                       const Vector3<double>& error, const double* slopes, int bias,
                       EquationTable& equations) {
  for (int axis = 0; axis < 3; ++axis) {
    const double weight = sensor.weights[3 * row + axis];
    sensor.keep(3 * row + axis, weight * error[axis]);
    if (weight == 0.0) continue;
    double* equation = equations.add(c, slopes + axis * c.count(), weight, error[axis]);
    if (bias >= 0) equation[equations.start + bias + axis] = weight;
  }
}

// The rows of a tracker at time t; where its noise lasts, those of its innovations.
inline void add_fix(const IntervalColumns& c, const Sensed& sensor, int row, double t,
                    const Vector3<double>& error, const double* slopes, Whitening* whitening,
                    EquationTable& equations) {
  if (!sensor.coloured) return add_sample(c, sensor, row, error, slopes, -1, equations);
  for (int axis = 0; axis < 3; ++axis) {
    const double weight = sensor.weights[3 * row + axis];
    sensor.keep(3 * row + axis, weight * error[axis]);
    if (weight == 0.0) continue;
    double* equation = equations.empty();
    equations.write(c, slopes + axis * c.count(), 1.0, equation);
    equation[equations.width - 1] = error[axis];
    whitening[axis].predict(t);
    const double S = whitening[axis].innovate(equation, 1 / (weight * weight));
    equations.scale(std::sqrt(S), equation);
  }
}

// The time of a row, or half-way to the next, s.
inline double time_of(const Recorded& recorded, int node) {
  const double* t = recorded.t + node / 2;
  return node % 2 ? (t[0] + t[1]) / 2 : t[0];
}

// Measured joints and wheels at a time, with calibrations and corrections; where it is that of a
// row, its number, else -1.
inline void read_joints(const Recorded& recorded, const LinearisedAt& at, int interval, double t,
                        int row, double t_start, double duration, IntervalMemory& memory,
                        JointNode& joints) {
  const int K = recorded.tree.joints, C = recorded.columns.corrected, L = recorded.local();
  const int W = recorded.wheels;
  const Cubics functions = joints.functions = cubics(t - t_start, duration);
  const JointState& shown = joints.shown;
  memory.knot = recorded.history.state(t, memory.knot, K, W, shown);
  const double *q = shown.q, *qd = shown.qd, *qdd = shown.qdd;
  const CalibrationPlaces& places = at.calibration.places;
  const double* zero = at.calibration.values + places.zero();
  const double* scale = at.calibration.values + places.scale();
  const double late = at.calibration.values[places.joint_clock()];
  // By the parabola through a row, half-way and the next row, or the one before the last:
  // accelerations count at rows alone.
  const bool turned_on = late != 0.0 && row >= 0 && recorded.rows > 1;
  const int way = row + 1 < recorded.rows ? 1 : -1;
  const double dt = turned_on ? recorded.t[row + way] - recorded.t[row] : 1.0;
  for (int k = 1; turned_on && k < 3; ++k)
    recorded.history.state(time_of(recorded, 2 * row + k * way), memory.knot, K, W,
                           memory.after[k - 1]);
  const auto rate_of = [&](double* JointState::* x, int k) {
    const auto at = [&](int n) { return (memory.after[n].*x)[k]; };
    return turned_on ? (4 * at(0) - 3 * (shown.*x)[k] - at(1)) / dt : 0.0;
  };
  for (int k = 0; k < K; ++k) {
    joints.q[k] = (1 + scale[k]) * q[k] + zero[k] + late * qd[k];
    joints.qd[k] = (1 + scale[k]) * qd[k] + late * qdd[k];
    joints.qdd[k] = (1 + scale[k]) * qdd[k] + late * rate_of(&JointState::qdd, k);
  }
  const auto correct = [&](int k, int c, double factor) {
    for (int f = 0; f < 4 && !recorded.passive(k); ++f) {
      const double correction =
          factor * at.local[(interval + f / 2) * L + recorded.corrections() + f % 2 * C + c];
      joints.q[k] += functions.value[f] * correction;
      joints.qd[k] += functions.rate[f] * correction;
      joints.qdd[k] += functions.acceleration[f] * correction;
    }
  };
  for (int c = 0; c < C; ++c) correct(recorded.corrected[c], c, 1.0);
  for (const Follower& each : recorded.followers) correct(each.joint, each.correction, each.factor);
  joints.t = t - recorded.t[0];
  const double *qd_rw = shown.qd_rw, *qdd_rw = shown.qdd_rw;
  const double* gain = at.calibration.values + places.wheel();
  joints.h_rw.setZero();
  joints.h_rw_rate.setZero();
  for (int i = 0; i < W; ++i) {
    const Vector3<double> a_I = momentum_of_wheel(at.calibration, recorded.A_rw, i);
    joints.h_rw += ((1 + gain[i]) * qd_rw[i] + late * qdd_rw[i]) * a_I;
    joints.h_rw_rate += ((1 + gain[i]) * qdd_rw[i] + late * rate_of(&JointState::qdd_rw, i)) * a_I;
  }
}

// What joints that were read mean for momentum, and its changes.
inline void expand_joints(const Recorded& recorded, const LinearisedAt& at, IntervalMemory& memory,
                          JointNode& joints) {
  expand(recorded.tree, recorded.theta_of, at.theta, recorded.corrected, recorded.followers,
         recorded.columns, joints.functions, joints.q, joints.qd, joints.qdd, memory.terms, joints);
  write_calibrations(recorded.tree, recorded.columns, at.calibration, joints.shown, recorded.A_rw,
                     memory.terms, joints.by);
}

// The same with passive joints, once they are integrated to a node of the base.
inline void expand_with_passive(const Recorded& recorded, const LinearisedAt& at,
                                IntervalMemory& memory, JointNode& joints, BaseNode& base) {
  show_passive(recorded, base, joints);
  expand_joints(recorded, at, memory, joints);
  add_passive(recorded, memory.terms, base, joints);
  set_law(recorded.planar, joints.terms.D, joints.terms.h_q + joints.h_rw, base);
}

// What acts at the fraction s of a row's step, by the parabola through its nodes.
inline void act_between(const Recorded& recorded, const LinearisedAt& at, int interval, double s,
                        const JointNode* const* nodes, BaseNode& base) {
  const double p[3] = {(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)};
  base.t = 0.0;
  for (int k = 0; k < 3; ++k) base.t += p[k] * nodes[k]->t;
  base.h_cm = contributed(contributions(base.t).h_cm, at.common);
  if (recorded.momentum >= 0)
    base.h_cm[2] += at.local[interval * recorded.local() + recorded.momentum];
  for (int k = 0; k < 3; ++k) {
    base.acting[k] = nodes[k]->acting;
    base.share[k] = p[k];
    base.h_cm += p[k] * nodes[k]->acting.value(ON_H);
  }
}

// The law of the base rate at the fraction s of a row's step, by the parabola through its nodes: a
// base that nutates fast needs smaller steps than joints that move slowly.
inline void set_law_between(const Recorded& recorded, const LinearisedAt& at, int interval,
                            double s, const JointNode* const* nodes, BaseNode& base) {
  act_between(recorded, at, interval, s, nodes, base);
  const double* p = base.share;
  Matrix3<double> D = Matrix3<double>::Zero();
  Vector3<double> h_moving = Vector3<double>::Zero();
  for (int k = 0; k < 3; ++k) {
    D += p[k] * nodes[k]->terms.D;
    h_moving += p[k] * (nodes[k]->terms.h_q + nodes[k]->h_rw);
    if (p[k] == 1.0) base.by = nodes[k]->by;
  }
  set_law(recorded.planar, D, h_moving, base);
  if (p[0] == 1.0 || p[1] == 1.0 || p[2] == 1.0) return;
  const int n = BY_R * recorded.columns.count();
  for (int i = 0; i < n; ++i)
    base.own_by[i] = p[0] * nodes[0]->by[i] + p[1] * nodes[1]->by[i] + p[2] * nodes[2]->by[i];
  base.by = base.own_by;
}

// The base at the interval's start.
inline void start_base(const Recorded& recorded, const LinearisedAt& at, int interval,
                       const JointNode& joints, BaseNode& base) {
  const IntervalColumns& c = recorded.columns;
  const JointNode* const nodes[3] = {&joints, &joints, &joints};
  set_law_between(recorded, at, interval, 0.0, nodes, base);
  set_attitude(Eigen::Map<const Quaternion<double>>(at.x_WB + 4 * interval), base);
  TableRows phi(base.phi, 3, c.count());
  phi.setZero();
  phi.middleCols<3>(c.turn()).setIdentity();
  set_forcing(c, base);
  set_rate_changes(c, base);
}

// The rows of gyro, attitude and position.
inline void add_samples(const Recorded& recorded, const LinearisedAt& at, int interval, int row,
                        const JointNode& joints, const BaseNode& base, IntervalMemory& memory,
                        EquationTable& equations) {
  const IntervalColumns& c = recorded.columns;
  const Calibration& calibration = at.calibration;
  const auto shown = [row](const Sensed& sensor) {
    return Vector3<double>(Eigen::Map<const Vector3<double>>(sensor.values + 3 * row));
  };
  // Perfect instruments show what is there: these slopes are not changed, and not copied.
  const auto slopes_of = [&](const double* perfect) {
    std::copy_n(perfect, 3 * c.count(), memory.slopes);
    return memory.slopes;
  };
  if (recorded.gyro.values) {
    const Eigen::Map<const Vector3<double>> bias(at.local + interval * recorded.local() + 3);
    Vector3<double> w = base.w;
    if (c.calibrations) calibrate_gyro(c, calibration, w, slopes_of(base.dw));
    add_sample(c, recorded.gyro, row, shown(recorded.gyro) - w - bias,
               c.calibrations ? memory.slopes : base.dw, 3, equations);
  }
  if (recorded.attitude.values) {
    const Quaternion<double> x =
        Eigen::Map<const Quaternion<double>>(recorded.attitude.values + 4 * row);
    Quaternion<double> x_WB = base.x_WB;
    if (c.calibrations) calibrate_attitude(c, calibration, base, x_WB, slopes_of(base.phi));
    add_fix(c, recorded.attitude, row, recorded.t[row], small_rotation(x_WB, x),
            c.calibrations ? memory.slopes : base.phi, memory.whitening[0], equations);
  }
  if (recorded.position.values) {
    Vector3<double> r = position(joints, base, at.common);
    position_slopes(c, joints, base, memory.slopes);
    if (c.calibrations)
      calibrate_position(c, calibration, joints, base, at.common, memory.velocity[0], r,
                         memory.slopes);
    add_fix(c, recorded.position, row, recorded.t[row], shown(recorded.position) - r, memory.slopes,
            memory.whitening[1], equations);
  }
}

// What a tracker shows of the velocity of S, and its slopes but for those that its clock adds.
inline Vector3<double> velocity_shown(const Recorded& recorded, const LinearisedAt& at,
                                      const JointNode& joints, const BaseNode& base,
                                      const Vector3<double>& a, IntervalMemory& memory) {
  const IntervalColumns& c = recorded.columns;
  Vector3<double> v = velocity(joints, base, at.common);
  std::copy_n(memory.velocity[0], 3 * c.count(), memory.moved);
  TableRows slopes(memory.moved, 3, c.count());
  add_outside(c, contributions(joints.t).v_cm, slopes);
  joints.acting.add(ON_V, Matrix3<double>::Identity(), slopes);
  if (c.calibrations) calibrate_velocity(c, at.calibration, base, a, v, memory.moved);
  return v;
}

// The row of a velocity v, once the slopes of the velocity are known at the next row too, dt later
// (or at the row before).
inline void add_velocity(const Recorded& recorded, const LinearisedAt& at, int row,
                         const Vector3<double>& v, const JointNode& joints, double dt,
                         IntervalMemory& memory, EquationTable& equations) {
  const IntervalColumns& c = recorded.columns;
  const double late = at.calibration.values[at.calibration.places.position_clock()];
  if (late != 0.0 && dt != 0.0) {
    const Matrix3<double> by = -late * Matrix3<double>::Identity();
    TableRows slopes(memory.moved, 3, c.count());
    add_rate_of_velocity(c, by, dt, memory.velocity[0], memory.velocity[1], memory.velocity[2],
                         memory.moved);
    joints.acting.add(ON_FELT, by, slopes);
  }
  const Eigen::Map<const Vector3<double>> shown(recorded.velocity.values + 3 * row);
  add_sample(c, recorded.velocity, row, shown - v, memory.moved, -1, equations);
}

// What goes on at the end of an interval: turn and biases.
inline void add_continuity(const Recorded& recorded, const LinearisedAt& at, int interval,
                           double duration, const BaseNode& end, EquationTable& equations) {
  const double root = walked(duration);
  const int L = recorded.local();
  const double *here = at.local + interval * L, *there = here + L;
  const Vector3<double> off = small_rotation<double>(
      Eigen::Map<const Quaternion<double>>(at.x_WB + 4 * (interval + 1)), end.x_WB);
  for (int k = 0; k < BIASES; ++k) {
    const double weight = 1 / (recorded.walk[k] * root);
    double* row;
    if (k < 3) {
      row =
          equations.add(recorded.columns, end.phi + k * recorded.columns.count(), weight, -off[k]);
    } else {
      row = equations.add(weight * (there[k] - here[k]));
      row[equations.start + k] = weight;
    }
    row[equations.end + k] = -weight;
  }
}

// All rows that the base's sensors give, and those of continuity; the base walks through the
// interval.
inline void linearise(const Recorded& recorded, const LinearisedAt& at, int interval,
                      IntervalMemory& memory, EquationTable& sensed, EquationTable& continuity) {
  const IntervalColumns& c = recorded.columns;
  const int first = recorded.edge[interval], last = recorded.edge[interval + 1];
  const int end = std::min(last, recorded.rows - 1);
  const double duration = recorded.t[end] - recorded.t[first];
  const bool late = at.calibration.values[at.calibration.places.position_clock()] != 0.0;
  const bool moving = recorded.accelerometer.values || recorded.velocity.values || late;
  const double t_start = recorded.t[first];
  const auto joints_at = [&](int node, JointNode& joints) {
    joints.acting = recorded.acting.at(node);
    read_joints(recorded, at, interval, time_of(recorded, node), node % 2 ? -1 : node / 2, t_start,
                duration, memory, joints);
    if (!recorded.springs) expand_joints(recorded, at, memory, joints);
  };
  JointNode *row = &memory.node[0], *half_way = &memory.node[1], *next = &memory.node[2];
  BaseNode *start = &memory.base[0], *middle = &memory.base[1], *stop = &memory.base[2];
  joints_at(2 * first, *row);
  if (recorded.springs) {
    const JointNode* const nodes[3] = {row, row, row};
    act_between(recorded, at, interval, 0.0, nodes, *start);
    start_passive(recorded, at, interval, memory.own, *row, *start);
    expand_with_passive(recorded, at, memory, *row, *start);
  } else {
    start_base(recorded, at, interval, *row, *start);
  }
  if (moving) velocity_slopes(c, *row, *start, memory.velocity[0]);
  const bool driven = recorded.torques.values;
  if (driven) start_torques(recorded, memory.own);
  double before = 0.0;
  const Sensed* const trackers[TRACKERS] = {&recorded.attitude, &recorded.position};
  for (int k = 0; k < TRACKERS; ++k)
    start_lasting(recorded, at, interval, *trackers[k], memory.whitening[k], sensed);
  for (int r = first; r < last; ++r) {
    add_samples(recorded, at, interval, r, *row, *start, memory, sensed);
    const Vector3<double> f_S = specific_force(*row, *start);
    const Matrix3<double> R_WB = start->R_WB;
    Vector3<double> v = Vector3<double>::Zero();
    if (recorded.velocity.values)
      v = velocity_shown(recorded, at, *row, *start, R_WB * f_S, memory);
    if (r == end) {
      if (recorded.velocity.values) add_velocity(recorded, at, r, v, *row, -before, memory, sensed);
      break;
    }
    const double dt = recorded.t[r + 1] - recorded.t[r];
    if (driven)
      add_joint_torques(recorded, at, *row, *start, r == first ? -1.0 : 0.0, -(before + dt) / 6,
                        memory.own);
    before = dt;
    TableRows felt(memory.felt, 3, c.count());
    felt = cross_matrix(f_S).lazyProduct(TableRows(start->phi, 3, c.count()));

    joints_at(2 * r + 1, *half_way);
    joints_at(2 * r + 2, *next);
    const JointNode* const nodes[3] = {row, half_way, next};
    const int steps = recorded.substeps;
    for (int i = 0; i < steps; ++i) {
      const double to_middle = (2 * i + 1) / (2.0 * steps), to_stop = (2 * i + 2) / (2.0 * steps);
      if (recorded.springs) {
        const double t = recorded.t[r];
        act_between(recorded, at, interval, to_middle, nodes, *middle);
        act_between(recorded, at, interval, to_stop, nodes, *stop);
        read_joints(recorded, at, interval, t + to_middle * dt, -1, t_start, duration, memory,
                    memory.own.joints[0]);
        read_joints(recorded, at, interval, t + to_stop * dt, i + 1 == steps ? r + 1 : -1, t_start,
                    duration, memory, memory.own.joints[1]);
        step_passive(recorded, at, dt / steps, *start, *middle, *stop, memory.own);
      } else {
        set_law_between(recorded, at, interval, to_middle, nodes, *middle);
        set_law_between(recorded, at, interval, to_stop, nodes, *stop);
        step(c, dt / steps, *start, *middle, *stop);
      }
      BaseNode* const at_half_way =
          2 * i + 1 == steps ? middle : (2 * i + 2 == steps ? stop : nullptr);
      if (at_half_way && recorded.springs)
        expand_with_passive(recorded, at, memory, *half_way, *at_half_way);
      if (at_half_way && moving) velocity_slopes(c, *half_way, *at_half_way, memory.velocity[1]);
      if (at_half_way && driven)
        add_joint_torques(recorded, at, *half_way, *at_half_way, 0.0, -2 * dt / 3, memory.own);
      std::swap(start, stop);
    }
    if (recorded.springs) expand_with_passive(recorded, at, memory, *next, *start);
    if (moving) velocity_slopes(c, *next, *start, memory.velocity[2]);
    if (recorded.velocity.values) add_velocity(recorded, at, r, v, *row, dt, memory, sensed);
    if (recorded.accelerometer.values) {
      add_rate_of_velocity(c, R_WB.transpose(), dt, memory.velocity[0], memory.velocity[1],
                           memory.velocity[2], memory.felt);
      row->acting.add(ON_FELT, R_WB.transpose(), felt);
      const Eigen::Map<const Vector3<double>> bias(at.local + interval * recorded.local() + 6),
          shown(recorded.accelerometer.values + 3 * r);
      add_sample(c, recorded.accelerometer, r, shown - f_S - bias, memory.felt, 6, sensed);
    }
    std::swap(row, next);
    std::swap(memory.velocity[0], memory.velocity[2]);
  }
  for (int k = 0; k < TRACKERS; ++k)
    end_lasting(recorded, at, interval, end, *trackers[k], *start, memory.whitening[k], sensed);
  if (driven) {
    add_joint_torques(recorded, at, *row, *start, 1.0, -before / 6, memory.own);
    add_torques(recorded, at, interval, duration, memory.own, sensed);
  }
  add_continuity(recorded, at, interval, duration, *start, continuity);
  add_passive_continuity(recorded, at, interval, duration, *start, continuity);
}

}  // namespace orbident
