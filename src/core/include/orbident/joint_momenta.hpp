// The momenta of the joints and how the energy changes with their positions (Eq. 11), without
// accelerations, and the derivatives of both.
//
//   h   = D w + D_q qd                          of all bodies, base axes
//   p_k = S_k . h_k                             dT/dqd_k
//   e_k = S_k' . h_k,   S_k' = V_k x S_k        dT/dq_k
//
// with S_k the field of joint k, h_k the momentum of all that it carries, with the system CM at
// rest, and V_k the motion of the body that carries the joint. h and p are linear in w and qd.
//
// Whatever changes, it is as if joint j and all that it carries moved by Z more, bodies had more
// momentum besides, l_k of all that joint k carries and l of all, and all followed by a velocity b
// that keeps the system CM at rest:
//
//   b = -l.p / M,   dh = l.h + s x b
//   dp_k = S_k . l_k + b . (I_k S_k).p
//   de_k = S_k' . l_k + b . ((I_k S_k').p + S_k.w x h_k.p)
//
// with I_k the composite that joint k carries, and where j carries k
//
//   dp_k += S_k . I_k Z,   de_k += S_k' . I_k Z + (Z x S_k) . h_k
//
//   by w      Z the turn of all, l = I_0 Z
//   by qd_j   Z = S_j;  l = I_j Z of all that carry j
//   by theta  l of unit bodies
//   by a displacement Y of j and of all that it carries (q_j: Y = S_j), as the motion V of the body
//   that carries j does not turn with them, Z = -Y x V;  l = Y x* h_j + I_j Z of all that carry j.
#pragma once

#include "orbident/calibration.hpp"

namespace orbident {

// Poses, masses and what each body carries.
inline void pose_and_weigh(const Tree& tree, const double* theta, const double* q,
                           Bodies<double>& at) {
  place(tree, q, at.pose, at.field);
  weigh(tree, theta, at.pose, at.mass);
  carry(tree, at.mass, at.carried);
}

// By w, by qd, by q, by beta, and by the calibrations of geometry.
struct DirectionPlaces {
  int joints, betas, geometries;
  int qd() const { return 3; }
  int q() const { return 3 + joints; }
  int beta() const { return 3 + 2 * joints; }
  int geometry() const { return beta() + betas; }
  int count() const { return geometry() + geometries; }
};

struct JointMomentaMemory {
  Bodies<double> bodies;
  Motion<double>* field_rate;  // joints: S_k'
  Vector3<double>* on_p;       // joints: what b is multiplied by in dp_k
  Vector3<double>* on_e;       // and in de_k
  Momentum<double>* more;      // bodies: l, of each with all that it carries
  double* slopes;              // h, p, e: 3 + 2 joints x directions
  double* values;              // 3 + 2 joints
};

// h, p and e at these rates; bodies are posed and weighed.
inline void joint_momenta(const Tree& tree, const double* qd, const Vector3<double>& w,
                          JointMomentaMemory& memory) {
  Bodies<double>& at = memory.bodies;
  double *p = memory.values + 3, *e = p + tree.joints;
  move(tree, at.field, w, qd, at.motion);
  Vector3<double> P = Vector3<double>::Zero();
  for (int i = 0; i < tree.bodies(); ++i) P += momentum_of(at.mass[i], at.motion[i]).p;
  const Vector3<double> v_cm = P / at.carried[0].m;
  for (int i = 0; i < tree.bodies(); ++i) {
    at.motion[i].u -= v_cm;
    at.momentum[i] = momentum_of(at.mass[i], at.motion[i]);
  }
  for (int k = tree.joints - 1; k >= 0; --k) {
    const int parent = tree.joint[k].parent;
    const Momentum<double>& load = at.momentum[k + 1];
    memory.field_rate[k] = turned(at.motion[parent], at.field[k]);
    p[k] = along(at.field[k], load);
    e[k] = along(memory.field_rate[k], load);
    at.momentum[parent].p += load.p;
    at.momentum[parent].h += load.h;
  }
  for (int r = 0; r < 3; ++r) memory.values[r] = at.momentum[0].h[r];
}

// The derivatives in one direction by `more`, which is left at zero.
inline void write_slopes(const Tree& tree, int direction, const DirectionPlaces& places,
                         JointMomentaMemory& memory) {
  const Mass<double>& whole = memory.bodies.carried[0];
  const int K = tree.joints, all = places.count();
  double* slopes = memory.slopes + direction;
  const Vector3<double> b = -memory.more[0].p / whole.m, h = memory.more[0].h + whole.s.cross(b);
  for (int r = 0; r < 3; ++r) slopes[r * all] = h[r];
  for (int k = 0; k < K; ++k) {
    const Momentum<double>& more = memory.more[k + 1];
    slopes[(3 + k) * all] = along(memory.bodies.field[k], more) + b.dot(memory.on_p[k]);
    slopes[(3 + K + k) * all] = along(memory.field_rate[k], more) + b.dot(memory.on_e[k]);
  }
  std::fill_n(memory.more, tree.bodies(), Momentum<double>::zero());
}

// Adds what joint j (-1: all bodies) and all that it carries do as they move by Z more.
inline void add_motion(const Tree& tree, int j, const Motion<double>& Z, int direction,
                       const DirectionPlaces& places, JointMomentaMemory& memory) {
  const Bodies<double>& at = memory.bodies;
  const int K = tree.joints, all = places.count();
  double* slopes = memory.slopes + direction;
  for (int k = std::max(j, 0); k < K; ++k) {
    int above = k;
    while (above > j) above = tree.joint[above].parent - 1;
    if (above != j) continue;
    const Momentum<double> change = momentum_of(at.carried[k + 1], Z);
    slopes[(3 + k) * all] += along(at.field[k], change);
    slopes[(3 + K + k) * all] +=
        along(memory.field_rate[k], change) + along(turned(Z, at.field[k]), at.momentum[k + 1]);
  }
}

// Of joint j, where l is the momentum that all that carry it have more.
inline void write_slopes_of_joint(const Tree& tree, int j, const Motion<double>& Z,
                                  const Momentum<double>& l, int direction,
                                  const DirectionPlaces& places, JointMomentaMemory& memory) {
  for (int k = j; k >= 0; k = tree.joint[k].parent - 1) memory.more[tree.joint[k].parent] = l;
  write_slopes(tree, direction, places, memory);
  add_motion(tree, j, Z, direction, places, memory);
}

inline void differentiate_by_rates(const Tree& tree, const DirectionPlaces& places,
                                   JointMomentaMemory& memory) {
  const Bodies<double>& at = memory.bodies;
  for (int r = 0; r < 3; ++r) {
    const Motion<double> turn = {Vector3<double>::Unit(r), Vector3<double>::Zero()};
    memory.more[0] = momentum_of(at.carried[0], turn);
    write_slopes(tree, r, places, memory);
    add_motion(tree, -1, turn, r, places, memory);
  }
  for (int j = 0; j < tree.joints; ++j)
    write_slopes_of_joint(tree, j, at.field[j], momentum_of(at.carried[j + 1], at.field[j]),
                          places.qd() + j, places, memory);
}

// By a displacement of joint j and all that it carries along a field Y.
inline void differentiate_by_displacement(const Tree& tree, int j, const Motion<double>& Y,
                                          int direction, const DirectionPlaces& places,
                                          JointMomentaMemory& memory) {
  const Bodies<double>& at = memory.bodies;
  const Motion<double> held = turned(Y, at.motion[tree.joint[j].parent]), Z = {-held.w, -held.u};
  const Momentum<double>& moving = at.momentum[j + 1];
  Momentum<double> l = momentum_of(at.carried[j + 1], Z);
  l.p += Y.w.cross(moving.p);
  l.h += Y.w.cross(moving.h) + Y.u.cross(moving.p);
  write_slopes_of_joint(tree, j, Z, l, direction, places, memory);
}

// By a parameter of beta: unit bodies move as theirs.
inline void differentiate_by_beta(const Tree& tree, const Sparse& theta_of, int b,
                                  const DirectionPlaces& places, JointMomentaMemory& memory) {
  const Bodies<double>& at = memory.bodies;
  Momentum<double>* more = memory.more;
  for (int x = theta_of.first[b]; x < theta_of.first[b + 1]; ++x) {
    const int body = theta_of.row[x] / PER_BODY;
    const MomentsAboutS unit =
        unit_moments(at.pose[body], at.motion[body], theta_of.row[x] % PER_BODY);
    more[body].p += theta_of.value[x] * unit.p;
    more[body].h += theta_of.value[x] * unit.h;
  }
  for (int k = tree.joints - 1; k >= 0; --k) {
    Momentum<double>& parent = more[tree.joint[k].parent];
    parent.p += more[k + 1].p;
    parent.h += more[k + 1].h;
  }
  write_slopes(tree, places.beta() + b, places, memory);
}

// All derivatives, from what `joint_momenta` left.
inline void differentiate_joint_momenta(const Tree& tree, const Sparse& theta_of,
                                        const DirectionPlaces& places,
                                        const Motion<double>* geometry, const int* displaced,
                                        JointMomentaMemory& memory) {
  const Bodies<double>& at = memory.bodies;
  std::fill_n(memory.more, tree.bodies(), Momentum<double>::zero());
  for (int k = 0; k < tree.joints; ++k) {
    memory.on_p[k] = momentum_of(at.carried[k + 1], at.field[k]).p;
    memory.on_e[k] = momentum_of(at.carried[k + 1], memory.field_rate[k]).p +
                     at.field[k].w.cross(at.momentum[k + 1].p);
  }
  differentiate_by_rates(tree, places, memory);
  for (int j = 0; j < tree.joints; ++j)
    differentiate_by_displacement(tree, j, at.field[j], places.q() + j, places, memory);
  for (int b = 0; b < places.betas; ++b) differentiate_by_beta(tree, theta_of, b, places, memory);
  for (int g = 0; g < places.geometries; ++g)
    differentiate_by_displacement(tree, displaced[g], geometry[g], places.geometry() + g, places,
                                  memory);
}

}  // namespace orbident
