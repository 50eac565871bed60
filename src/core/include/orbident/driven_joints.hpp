// Joints whose torque is measured (Eq. 11): their momenta, linear in all unknowns.
//
//   p   = S_k . h_k + A qd_k                              momentum, with the rotor's beside it
//   p'  = S_k' . h_k + t - d qd_k - c sign(qd_k) - o      with  S_k' = V_k x S_k
//
// where a sensor shows 1 + g times the torque t. About the system CM, with the momentum P of all
// and what all that joint k carries has of it, P_k at its unit rate, both seen from S,
//
//   S_k . h_k = (S_k . h_k)_S - P . P_k / M,   S_k' . h_k = (S_k' . h_k)_S - P . dP/dq_k / M
//
// which are linear in pi as Y is (regressors.hpp). Base axes.
//
// p is a nuisance: every sample says what it is, and the torque what it gains until the next one,
// by the trapezoidal rule. Where that is not known, all may have happened to p: between samples far
// apart, while the joint stands or turns back, as sticking friction may hold it, and without a
// torque. Noise of the rates counts as independent of that of the conservation laws, as theirs is
// of each other's.
#pragma once

#include "orbident/filter_state.hpp"

namespace orbident {

constexpr Real MOST_MOMENTUM =
    1e3;  // N m s: more no joint has, nor does a torque give between samples

inline bool carries(const Tree& tree, int joint, int body) {
  while (body > joint + 1) body = tree.joint[body - 1].parent;
  return body == joint + 1;
}

// The linear momentum relative to S that a unit of the parameter `c` of theta has at a motion.
inline Vector unit_momentum(const Bodies<Real>& at, const Motion<Real>& motion, int c) {
  const Pose<Real>& pose = at.pose[c / PER_BODY];
  const int parameter = c % PER_BODY;
  if (parameter == 0) return motion.u + motion.w.cross(pose.d);
  return parameter <= 3 ? Vector(motion.w.cross(pose.R.col(parameter - 1))) : Vector::Zero();
}

// What one joint adds up to at a sample; P, A and W are of the sample's regressors.
struct JointRows {
  const ConservationModel& model;
  EquationMemory& memory;
  const SystemInertia<Real>& all;
  int joint;
  Motion<Real> field;       // S_k
  Motion<Real> field_rate;  // S_k'

  // The row of pi: along(field, momentum) of all that the joint carries, about the CM, where a unit
  // of a parameter's P changes by `change` with the joint.
  template <class Change>
  void write(const Motion<Real>& along_field, const Change& change, Real* row) const {
    const Tree& tree = model.robot.tree;
    const int thetas = PER_BODY * tree.bodies(), phis = model.sets.phis();
    const Rows3<Real> P(memory.columns + 3 * thetas, 3, thetas),
        A(memory.columns + 6 * thetas, 3, thetas), W(memory.W, 3, phis);
    Rows3<Real> by_joint(memory.by_joint, 3, phis);
    const Sparse &linear = model.sets.theta_of_linear, &sigma = model.sets.theta_of_sigma;
    for (int c = 0; c < linear.columns; ++c) {
      Real sum = 0;
      for (int k = linear.first[c]; k < linear.first[c + 1]; ++k) {
        const int at = linear.row[k];
        if (carries(tree, joint, at / PER_BODY))
          sum += linear.value[k] * (along_field.w.dot(A.col(at)) + along_field.u.dot(P.col(at)));
      }
      row[c] = sum;
    }
    for (int c = 0; c < phis; ++c) {
      Vector sum = Vector::Zero();
      for (int k = sigma.first[c]; k < sigma.first[c + 1]; ++k)
        if (carries(tree, joint, sigma.row[k] / PER_BODY))
          sum += sigma.value[k] * change(sigma.row[k]);
      by_joint.col(c) = sum;
    }
    for (int k = 0; k < model.sets.products; ++k) {
      // W is -P.
      const int a = model.sets.pair[2 * k], b = model.sets.pair[2 * k + 1];
      const Real sum = W.col(a).dot(by_joint.col(b)) + W.col(b).dot(by_joint.col(a));
      row[linear.columns + k] = a == b ? sum / 2 : sum;
    }
  }

  void write_momentum(Real* row) const {
    write(field, [&](int c) { return unit_momentum(memory.bodies, field, c); }, row);
  }

  void write_slope(Real* row) const {
    const int thetas = PER_BODY * model.robot.tree.bodies();
    const Rows3<Real> P(memory.columns + 3 * thetas, 3, thetas);
    write(field_rate, [&](int c) {
      return Vector(field.w.cross(P.col(c)) + unit_momentum(memory.bodies, field_rate, c));
    }, row);
  }

  // D_q: how the momentum p changes with w.
  Vector by_rate() const {
    const Momentum<Real>& own = memory.bodies.momentum[joint];
    return own.h - all.r_cm.cross(own.p);
  }

  // How the slope of the energy changes with w, which is how the momentum of all does with q_k.
  Vector slope_by_rate() const {
    const Eigen::Map<const Vector> p(memory.load + 6 * (joint + 1)),
        h(memory.load + 6 * (joint + 1) + 3), P(memory.load);
    const Mass<Real>& load = memory.bodies.carried[joint + 1];
    const Momentum<Real> turning = momentum_of(load, field_rate);
    const Vector dp = field.w.cross(p) + turning.p;
    const Vector dh = field.w.cross(h) + field.u.cross(p) + turning.h;
    return dh - memory.bodies.momentum[joint].p.cross(P) / all.M - all.r_cm.cross(dp);
  }

  // The variance that noise of all rates adds to p.
  Real variance(Real armature) const {
    const Bodies<Real>& at = memory.bodies;
    const SensorNoise& noise = model.noise;
    const Vector D_q = by_rate();
    Real turning = 0, swinging = 0;
    for (int k = 0; k < model.axes.momenta; ++k) {
      const Real each = noise.gyro * D_q[model.axes.momentum[k]];
      turning += each * each;
    }
    for (int j = 0; j < model.robot.tree.joints; ++j) {
      Real D_qq = -at.momentum[j].p.dot(at.momentum[joint].p) / all.M;
      if (carries(model.robot.tree, joint, j + 1))
        D_qq += along(field, at.momentum[j]);
      else if (carries(model.robot.tree, j, joint + 1))
        D_qq += along(at.field[j], at.momentum[joint]);
      if (j == joint) D_qq += armature;
      swinging += noise.joint_rates * noise.joint_rates * D_qq * D_qq;
    }
    return turning + swinging;
  }
};

// [p, h] of every body with all that it carries, about S.
inline void load_bodies(const Tree& tree, EquationMemory& memory) {
  Eigen::Map<Eigen::Matrix<Real, 6, Eigen::Dynamic>> load(memory.load, 6, tree.bodies());
  for (int i = 0; i < tree.bodies(); ++i) {
    const Momentum<Real> own = momentum_of(memory.bodies.mass[i], memory.bodies.motion[i]);
    load.col(i) << own.p, own.h;
  }
  for (int k = tree.joints - 1; k >= 0; --k) load.col(tree.joint[k].parent) += load.col(k + 1);
}

// The rows [x, pi, phi | right-hand side] of driven joints, from what `conservation_equations`
// left: first those of p, whitened, or zeros without a torque, then how p changes: their values
// less their right-hand sides.
inline void driven_equations(const ConservationModel& model, const Measurement& at,
                             EquationMemory& memory, Real* rows, int stride) {
  const int D = model.driven.count, n = model.nuisances(), b_g = model.gyro_bias();
  const int rhs = n + model.parameters();
  for (int i = 0; i < 2 * D * stride; ++i) rows[i] = 0.0;
  if (!D) return;
  load_bodies(model.robot.tree, memory);
  const SystemInertia<Real> all = system_inertia(memory.bodies.carried[0]);
  const Vector excess = rate_excess(model.axes, at);
  for (int i = 0; i < D; ++i) {
    const DrivenJoint& own = model.driven.each[i];
    const Bodies<Real>& bodies = memory.bodies;
    const Motion<Real>& field = bodies.field[own.joint];
    const JointRows joint{
        model,     memory, all,
        own.joint, field,  turned(bodies.motion[model.robot.tree.joint[own.joint].parent], field)};
    Real *const p = rows + i * stride, *const slope = p + D * stride;
    joint.write_slope(slope + n);
    const Vector D_q = joint.by_rate(), turning = joint.slope_by_rate();
    for (int k = 0; k < model.axes.momenta; ++k) slope[b_g + k] = -turning[model.axes.momentum[k]];
    if (!std::isfinite(at.impulse[i])) continue;
    joint.write_momentum(p + n);
    for (int k = 0; k < model.axes.momenta; ++k) p[b_g + k] = -D_q[model.axes.momentum[k]];
    p[model.joint_momentum() + i] = -1;
    p[model.drives() + DRIVES * i + armature] = at.qd[own.joint];
    p[rhs] = -D_q.dot(excess);
    const Real white = 1 / std::sqrt(joint.variance(own.known[armature]));
    for (int c = 0; c <= rhs; ++c) p[c] *= white;
  }
}

// How a driven joint moved from the last sample to this one.
struct DrivenStep {
  bool followed;  // else nothing is known of what its momentum gained
  Real dq, impulse;
  DrivenStep(const ConservationModel& model, const FilterState& state, const Measurement& at, int i,
             Real dt) {
    const DrivenJoint& own = model.driven.each[i];
    const Real before = state.qd[i], now = at.qd[own.joint];
    dq = at.q[own.joint] - state.q[i];
    impulse = at.impulse[i] - state.impulse[i];
    const bool turns = std::abs(before) > own.still && std::abs(now) > own.still;
    // Not a number is no less than anything.
    followed = std::abs(impulse) < MOST_MOMENTUM && dt <= model.driven.longest && turns &&
               before * now > 0;
  }
};

// Nothing is known of the nuisance j any more: what its row says of it and of all others is rotated
// into that row alone, which goes.
inline void forget(Real* top, int stride, int width, int j) {
  Real* const own = top + j * stride;
  for (int i = j - 1; i >= 0; --i) {
    Real* const row = top + i * stride;
    const Real length = std::sqrt(row[j] * row[j] + own[j] * own[j]);
    const Real c = own[j] / length, s = row[j] / length;
    for (int k = i; k < width; ++k) {
      const Real before = row[k];
      row[k] = c * before - s * own[k];
      own[k] = s * before + c * own[k];
    }
  }
  for (int k = 0; k < width; ++k) own[k] = 0.0;
  own[j] = 1 / MOST_MOMENTUM;
}

// What noise of the torques adds to the momenta of driven joints over dt; those that no torque
// follows are forgotten.
inline void momenta_walk(const FilterModel& model, FilterState& state, const Measurement& at,
                         Real dt, int width, Real* walk) {
  const ConservationModel& laws = model.laws;
  for (int i = 0; i < laws.driven.count; ++i) {
    walk[i] = laws.driven.each[i].walk * std::sqrt(dt);
    if (DrivenStep(laws, state, at, i, dt).followed) continue;
    forget(state.top, model.sizes().top_stride(), width, laws.joint_momentum() + i);
  }
}

// Moves the rows of the nuisances on by what the momenta gained, linear in all unknowns; then
// `rows` are the slopes of this sample, and zero. A step with p_before = p - (slope, -drives) x dt
// + impulse adds to the other columns what N has for p.
inline void follow_momenta(const FilterModel& model, FilterState& state, const Measurement& at,
                           Real dt, int width, Real* rows, int stride) {
  const ConservationModel& laws = model.laws;
  const FilterSizes size = model.sizes();
  const int top_stride = size.top_stride();
  for (int i = 0; i < size.driven; ++i) {
    const DrivenStep step(laws, state, at, i, dt);
    const int joint = laws.driven.each[i].joint, own = laws.drives() + DRIVES * i;
    Real *const before = state.slope + i * top_stride, *const now = rows + i * stride;
    for (int r = 0; step.followed && r <= laws.joint_momentum() + i; ++r) {
      Real* const row = state.top + r * top_stride;
      const Real share = row[laws.joint_momentum() + i];
      for (int c = 0; c < width; ++c) row[c] -= share * dt / 2 * (before[c] + now[c]);
      row[width - 1] += share * step.impulse;
      row[own + viscous] += share * step.dq;
      row[own + coulomb] += share * (step.dq > 0 ? dt : -dt);
      row[own + offset] += share * dt;
      row[own + scale] += share * step.impulse;
    }
    for (int c = 0; c < width; ++c) before[c] = now[c];
    for (int c = 0; c < width; ++c) now[c] = 0.0;
    state.q[i] = at.q[joint];
    state.qd[i] = at.qd[joint];
    state.impulse[i] = at.impulse[i];
  }
}

}  // namespace orbident
