// The equations of one shooting interval, linear in changes of the unknowns, whitened:
//
//   what the sensors showed - what is predicted = slopes x change
//   attitude and biases at the end = those at the next interval's start     (random walk)
//   lasting noise at the end = that at the next interval's start            (lasting_noise.hpp)
//   corrections of the joints at the end = 0                                (prior)
//
// Unknowns, z of a boundary and g common to all, and the columns of a table:
//
//   z       turn 3 | gyro bias 3 | accelerometer bias 3 | lasting noise of attitude and position,
//           axis by axis | corrections: values, rates
//   g       outside | beta | calibration
//   table   z near | z far | g | right-hand side
//
// near is the boundary that is eliminated, the start or the end.
#pragma once

#include "orbident/lasting_noise.hpp"

namespace orbident {

// The rows of a sensor with three axes; `bias` is where its bias is in z, or -1.
template <class T>
void add_sample(const IntervalColumns& c, const Sensed<T>& sensor, int row, const Vector3<T>& error,
                const T* slopes, int bias, EquationTable<T>& equations) {
  for (int axis = 0; axis < 3; ++axis) {
    const T weight = sensor.weights[3 * row + axis];
    sensor.keep(3 * row + axis, weight * error[axis]);
    if (weight == T(0)) continue;
    T* equation = equations.add(c, slopes + axis * c.count(), weight, error[axis]);
    if (bias >= 0) equation[equations.start + bias + axis] = weight;
  }
}

// The rows of a tracker at time t; where its noise lasts, those of its innovations.
template <class T>
void add_fix(const IntervalColumns& c, const Sensed<T>& sensor, int row, const T& t,
             const Vector3<T>& error, const T* slopes, Whitening<T>* whitening,
             EquationTable<T>& equations) {
  if (!sensor.coloured) return add_sample(c, sensor, row, error, slopes, -1, equations);
  for (int axis = 0; axis < 3; ++axis) {
    const T weight = sensor.weights[3 * row + axis];
    sensor.keep(3 * row + axis, weight * error[axis]);
    if (weight == T(0)) continue;
    T* equation = equations.empty();
    equations.write(c, slopes + axis * c.count(), T(1), equation);
    equation[equations.width - 1] = error[axis];
    whitening[axis].predict(t);
    const T S = whitening[axis].innovate(equation, 1 / (weight * weight));
    equations.scale(std::sqrt(S), equation);
  }
}

// Joints and wheels at a node, with calibrations and corrections.
template <class T>
void place_joints(const Recorded<T>& recorded, const LinearisedAt<T>& at, int interval, int node,
                  const T& t_start, const T& duration, IntervalMemory<T>& memory,
                  JointNode<T>& joints) {
  const int K = recorded.tree.joints, C = recorded.columns.corrected, L = recorded.local();
  const int W = recorded.wheels, row = node / 2;
  const auto time = [&](int at) {
    return at % 2 ? (recorded.t[at / 2] + recorded.t[at / 2 + 1]) / 2 : recorded.t[at / 2];
  };
  const T t = time(node);
  const Cubics<T> functions = cubics<T>(t - t_start, duration);
  const JointState<T>& shown = memory.shown[0];
  memory.knot = recorded.history.state(t, memory.knot, K, W, shown);
  const T *q = shown.q, *qd = shown.qd, *qdd = shown.qdd;
  const CalibrationPlaces& places = at.calibration.places;
  const T* zero = at.calibration.values + places.zero();
  const T* scale = at.calibration.values + places.scale();
  const T late = at.calibration.values[places.joint_clock()];
  // By the parabola through a row, half-way and the next row: accelerations count at rows alone.
  const bool turned_on = late != T(0) && node % 2 == 0 && row + 1 < recorded.rows;
  const T dt = turned_on ? recorded.t[row + 1] - recorded.t[row] : T(1);
  for (int k = 1; turned_on && k < 3; ++k)
    recorded.history.state(time(node + k), memory.knot, K, W, memory.shown[k]);
  const auto rate_of = [&](T* JointState<T>::* x, int k) {
    const auto at = [&](int n) { return (memory.shown[n].*x)[k]; };
    return turned_on ? (4 * at(1) - 3 * at(0) - at(2)) / dt : T(0);
  };
  for (int k = 0; k < K; ++k) {
    memory.q[k] = (1 + scale[k]) * q[k] + zero[k] + late * qd[k];
    memory.qd[k] = (1 + scale[k]) * qd[k] + late * qdd[k];
    memory.qdd[k] = (1 + scale[k]) * qdd[k] + late * rate_of(&JointState<T>::qdd, k);
  }
  for (int c = 0; c < C; ++c) {
    const int k = recorded.corrected[c];
    for (int f = 0; f < 4; ++f) {
      const T correction =
          at.local[(interval + f / 2) * L + recorded.corrections() + f % 2 * C + c];
      memory.q[k] += functions.value[f] * correction;
      memory.qd[k] += functions.rate[f] * correction;
      memory.qdd[k] += functions.acceleration[f] * correction;
    }
  }
  joints.t = t - recorded.t[0];
  joints.acting = recorded.acting.at(node);
  const T *qd_rw = shown.qd_rw, *qdd_rw = shown.qdd_rw;
  const T* gain = at.calibration.values + places.wheel();
  joints.h_rw.setZero();
  joints.h_rw_rate.setZero();
  for (int i = 0; i < W; ++i) {
    const Eigen::Map<const Vector3<T>> a_I(recorded.A_rw + 3 * i);
    joints.h_rw += ((1 + gain[i]) * qd_rw[i] + late * qdd_rw[i]) * a_I;
    joints.h_rw_rate +=
        ((1 + gain[i]) * qdd_rw[i] + late * rate_of(&JointState<T>::qdd_rw, i)) * a_I;
  }
  expand(recorded.tree, recorded.theta_of, at.theta, recorded.corrected, recorded.columns,
         functions, memory.q, memory.qd, memory.qdd, memory.terms, joints);
  write_calibrations<T>(recorded.tree, recorded.columns, at.calibration,
                        {q, qd, qdd, qd_rw, qdd_rw}, recorded.A_rw, memory.terms, joints.by);
}

// The law of the base rate at the fraction s of a row's step, by the parabola through its nodes: a
// base that nutates fast needs smaller steps than joints that move slowly.
template <class T>
void set_law_between(const Recorded<T>& recorded, const LinearisedAt<T>& at, const T& s,
                     const JointNode<T>* const* nodes, BaseNode<T>& base) {
  const T p[3] = {(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)};
  Matrix3<T> D = Matrix3<T>::Zero();
  Vector3<T> h_moving = Vector3<T>::Zero();
  base.t = T(0);
  for (int k = 0; k < 3; ++k) {
    D += p[k] * nodes[k]->terms.D;
    h_moving += p[k] * (nodes[k]->terms.h_q + nodes[k]->h_rw);
    base.t += p[k] * nodes[k]->t;
    if (p[k] == T(1)) base.by = nodes[k]->by;
  }
  base.h_cm = contributed(contributions(base.t).h_cm, at.common);
  for (int k = 0; k < 3; ++k) {
    base.acting[k] = nodes[k]->acting;
    base.share[k] = p[k];
    base.h_cm += p[k] * nodes[k]->acting.value(ON_H);
  }
  set_law(recorded.planar, D, h_moving, base);
  if (p[0] == T(1) || p[1] == T(1) || p[2] == T(1)) return;
  const int n = BY_R * recorded.columns.count();
  for (int i = 0; i < n; ++i)
    base.own_by[i] = p[0] * nodes[0]->by[i] + p[1] * nodes[1]->by[i] + p[2] * nodes[2]->by[i];
  base.by = base.own_by;
}

// The base at the interval's start.
template <class T>
void start_base(const Recorded<T>& recorded, const LinearisedAt<T>& at, int interval,
                const JointNode<T>& joints, BaseNode<T>& base) {
  const IntervalColumns& c = recorded.columns;
  const JointNode<T>* const nodes[3] = {&joints, &joints, &joints};
  set_law_between(recorded, at, T(0), nodes, base);
  set_attitude<T>(Eigen::Map<const Quaternion<T>>(at.x_WB + 4 * interval), base);
  TableRows<T, 3> phi(base.phi, 3, c.count());
  phi.setZero();
  phi.template middleCols<3>(c.turn()).setIdentity();
  set_forcing(c, base);
  set_rate_changes(c, base);
}

// The rows of gyro, attitude, position and velocity.
template <class T>
void add_samples(const Recorded<T>& recorded, const LinearisedAt<T>& at, int interval, int row,
                 const JointNode<T>& joints, const BaseNode<T>& base, IntervalMemory<T>& memory,
                 EquationTable<T>& equations) {
  const IntervalColumns& c = recorded.columns;
  const Calibration<T>& calibration = at.calibration;
  const auto shown = [row](const Sensed<T>& sensor) {
    return Vector3<T>(Eigen::Map<const Vector3<T>>(sensor.values + 3 * row));
  };
  // Perfect instruments show what is there: these slopes are not changed, and not copied.
  const auto slopes_of = [&](const T* perfect) {
    std::copy_n(perfect, 3 * c.count(), memory.slopes);
    return memory.slopes;
  };
  if (recorded.gyro.values) {
    const Eigen::Map<const Vector3<T>> bias(at.local + interval * recorded.local() + 3);
    Vector3<T> w = base.w;
    if (c.calibrations) calibrate_gyro(c, calibration, w, slopes_of(base.dw));
    add_sample<T>(c, recorded.gyro, row, shown(recorded.gyro) - w - bias,
                  c.calibrations ? memory.slopes : base.dw, 3, equations);
  }
  if (recorded.attitude.values) {
    const Quaternion<T> x = Eigen::Map<const Quaternion<T>>(recorded.attitude.values + 4 * row);
    Quaternion<T> x_WB = base.x_WB;
    if (c.calibrations) calibrate_attitude(c, calibration, base, x_WB, slopes_of(base.phi));
    add_fix<T>(c, recorded.attitude, row, recorded.t[row], small_rotation(x_WB, x),
               c.calibrations ? memory.slopes : base.phi, memory.whitening[0], equations);
  }
  if (recorded.position.values) {
    Vector3<T> r = position(joints, base, at.common);
    position_slopes(c, joints, base, memory.slopes);
    if (c.calibrations)
      calibrate_position(c, calibration, joints, base, at.common, memory.velocity[0], r,
                         memory.slopes);
    add_fix<T>(c, recorded.position, row, recorded.t[row], shown(recorded.position) - r,
               memory.slopes, memory.whitening[1], equations);
  }
  if (recorded.velocity.values) {
    Vector3<T> v = velocity(joints, base, at.common);
    TableRows<T, 3> slopes(slopes_of(memory.velocity[0]), 3, c.count());
    add_outside(c, contributions(joints.t).v_cm, slopes);
    joints.acting.add(ON_V, Matrix3<T>::Identity(), slopes);
    if (c.calibrations) calibrate_velocity(c, calibration, base, v, memory.slopes);
    add_sample<T>(c, recorded.velocity, row, shown(recorded.velocity) - v, memory.slopes, -1,
                  equations);
  }
}

// What goes on at the end of an interval: turn and biases.
template <class T>
void add_continuity(const Recorded<T>& recorded, const LinearisedAt<T>& at, int interval,
                    const T& duration, const BaseNode<T>& end, EquationTable<T>& equations) {
  // An interval of one row lasts no time.
  constexpr double MOMENT = 1e-3;
  const T root = std::sqrt(std::max(duration, T(MOMENT)));
  const int L = recorded.local();
  const T *here = at.local + interval * L, *there = here + L;
  const Vector3<T> off =
      small_rotation<T>(Eigen::Map<const Quaternion<T>>(at.x_WB + 4 * (interval + 1)), end.x_WB);
  for (int k = 0; k < BIASES; ++k) {
    const T weight = 1 / (recorded.walk[k] * root);
    T* row;
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
template <class T>
void linearise(const Recorded<T>& recorded, const LinearisedAt<T>& at, int interval,
               IntervalMemory<T>& memory, EquationTable<T>& sensed, EquationTable<T>& continuity) {
  const IntervalColumns& c = recorded.columns;
  const int first = recorded.edge[interval], last = recorded.edge[interval + 1];
  const int end = std::min(last, recorded.rows - 1);
  const T duration = recorded.t[end] - recorded.t[first];
  const bool late = at.calibration.values[at.calibration.places.position_clock()] != T(0);
  const bool moving = recorded.accelerometer.values || recorded.velocity.values || late;
  const auto joints_at = [&](int node, JointNode<T>& joints) {
    place_joints(recorded, at, interval, node, recorded.t[first], duration, memory, joints);
  };
  JointNode<T>*row = &memory.node[0], *half_way = &memory.node[1], *next = &memory.node[2];
  BaseNode<T>*start = &memory.base[0], *middle = &memory.base[1], *stop = &memory.base[2];
  joints_at(2 * first, *row);
  start_base(recorded, at, interval, *row, *start);
  if (moving) velocity_slopes(c, *row, *start, memory.velocity[0]);
  const Sensed<T>* const trackers[TRACKERS] = {&recorded.attitude, &recorded.position};
  for (int k = 0; k < TRACKERS; ++k)
    start_lasting(recorded, at, interval, *trackers[k], memory.whitening[k], sensed);
  for (int r = first; r < last; ++r) {
    add_samples(recorded, at, interval, r, *row, *start, memory, sensed);
    if (r == end) break;
    const Vector3<T> f_S = specific_force(*row, *start);
    const Matrix3<T> R_WB = start->R_WB;
    TableRows<T, 3> felt(memory.felt, 3, c.count());
    felt = cross_matrix(f_S).lazyProduct(TableRows<T, 3>(start->phi, 3, c.count()));

    joints_at(2 * r + 1, *half_way);
    joints_at(2 * r + 2, *next);
    const JointNode<T>* const nodes[3] = {row, half_way, next};
    const T dt = recorded.t[r + 1] - recorded.t[r];
    const int steps = recorded.substeps;
    for (int i = 0; i < steps; ++i) {
      set_law_between(recorded, at, T(2 * i + 1) / T(2 * steps), nodes, *middle);
      set_law_between(recorded, at, T(2 * i + 2) / T(2 * steps), nodes, *stop);
      step(c, dt / T(steps), *start, *middle, *stop);
      if (moving && 2 * i + 1 == steps) velocity_slopes(c, *half_way, *middle, memory.velocity[1]);
      if (moving && 2 * i + 2 == steps) velocity_slopes(c, *half_way, *stop, memory.velocity[1]);
      std::swap(start, stop);
    }
    if (moving) velocity_slopes(c, *next, *start, memory.velocity[2]);
    if (recorded.accelerometer.values) {
      add_rate_of_velocity(c, R_WB, dt, memory.velocity[0], memory.velocity[1], memory.velocity[2],
                           memory.felt);
      row->acting.add(ON_FELT, R_WB.transpose(), felt);
      const Eigen::Map<const Vector3<T>> bias(at.local + interval * recorded.local() + 6),
          shown(recorded.accelerometer.values + 3 * r);
      add_sample<T>(c, recorded.accelerometer, r, shown - f_S - bias, memory.felt, 6, sensed);
    }
    std::swap(row, next);
    std::swap(memory.velocity[0], memory.velocity[2]);
  }
  for (int k = 0; k < TRACKERS; ++k)
    end_lasting(recorded, at, interval, end, *trackers[k], memory.whitening[k], sensed);
  add_continuity(recorded, at, interval, duration, *start, continuity);
}

}  // namespace orbident
