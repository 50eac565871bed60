// The kinematic tree: where every body is, and which motion each joint gives to what it carries.
//
// Joint k moves body k + 1; a parent comes before its children. Everything is in base axes and seen
// from the feature point S, whose own velocity drops out. A rigid motion is the pair (w, u) of its
// angular velocity and the velocity that its field has at S.
#pragma once

#include "orbident/rotations.hpp"
#include "orbident/scalar.hpp"

namespace orbident {

// A joint turns its body about the unit vector a (Rodrigues), or slides it along a:
//
//   R_Pi = R_PJ (a a^T + cos q (1 - a a^T) + sin q [a]x)   or   R_Pi = R_PJ.
struct Joint {
  int parent;
  bool revolute;         // else prismatic
  Vector3<Real> axis;    // unit vector, parent's axes
  Vector3<Real> p_PJ;    // from the parent's origin, m
  Matrix3<Real> fixed;   // what R_Pi is at any q
  Matrix3<Real> cosine;  // what it has beside that, times cos q
  Matrix3<Real> sine;    // and times sin q

  // The axis in joint axes; R_PJ: joint axes at q = 0 in the parent's.
  Joint(int parent, bool revolute, const Vector3<Real>& a, const Matrix3<Real>& R_PJ,
        const Vector3<Real>& p_PJ)
      : parent(parent), revolute(revolute), axis(R_PJ * a), p_PJ(p_PJ), fixed(R_PJ) {
    if (revolute) fixed *= a * a.transpose();
    cosine = R_PJ - fixed;
    sine = R_PJ * cross_matrix(a);
  }
};

// A view of a constant table.
struct Tree {
  const Joint* joint;
  int joints;
  constexpr int bodies() const { return joints + 1; }
};

template <class T>
struct Pose {
  Matrix3<T> R;  // R_Bi
  Vector3<T> d;  // p_SBi, m
};

template <class T>
struct Motion {
  Vector3<T> w;  // rad/s
  Vector3<T> u;  // velocity of the field at S, m/s
};

// The turn of a field with a rigid motion X.
template <class T>
Motion<T> turned(const Motion<T>& X, const Motion<T>& field) {
  return {X.w.cross(field.w), X.w.cross(field.u) + X.u.cross(field.w)};
}

// Forward kinematics: the poses of all bodies, and the motion that a unit rate of each joint gives
// to all that it carries: revolute w = a, u = d x a; prismatic w = 0, u = a.
template <class T>
void place(const Tree& tree, const T* q, Pose<T>* pose, Motion<T>* field) {
  using std::cos;
  using std::sin;
  pose[0].R.setIdentity();
  pose[0].d.setZero();
  for (int k = 0; k < tree.joints; ++k) {
    const Joint& joint = tree.joint[k];
    const Pose<T>& parent = pose[joint.parent];
    const Vector3<T> a = parent.R * joint.axis.template cast<T>();
    Pose<T>& body = pose[k + 1];
    body.d = parent.d + parent.R * joint.p_PJ.template cast<T>();
    Matrix3<T> R_Pi = joint.fixed.template cast<T>();
    if (joint.revolute) {
      R_Pi +=
          cos(q[k]) * joint.cosine.template cast<T>() + sin(q[k]) * joint.sine.template cast<T>();
      field[k] = {a, body.d.cross(a)};
    } else {
      body.d += q[k] * a;
      field[k] = {Vector3<T>::Zero(), a};
    }
    body.R = parent.R * R_Pi;
  }
}

// The motions of all bodies at the base rate w and the joint rates qd, relative to S.
template <class T>
void move(const Tree& tree, const Motion<T>* field, const Vector3<T>& w, const T* qd,
          Motion<T>* motion) {
  motion[0] = {w, Vector3<T>::Zero()};
  for (int k = 0; k < tree.joints; ++k) {
    const Motion<T>& parent = motion[tree.joint[k].parent];
    motion[k + 1] = {parent.w + qd[k] * field[k].w, parent.u + qd[k] * field[k].u};
  }
}

}  // namespace orbident
