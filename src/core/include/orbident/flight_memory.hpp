// How a flight computer's filter lies in the caller's array, and its model from the constant table.
//
//   | mark, last sample, filter, detector, checksum | joints, wheels | room for one step |
//
// The first part is all that is carried from sample to sample, and the checksum of a copy of it.
// Nothing in it is an address, so that it may be copied away, and back to another place.
#pragma once

#include <new>

#include "orbident/flight.h"
#include "orbident/information_filter.hpp"
#include "orbident/opening.hpp"
#include "orbident/sound_state.hpp"

namespace orbident::flight {

constexpr Sparse view(const orbident_sparse& table) {
  return {table.first, table.row, table.value, table.columns};
}

constexpr FilterModel model_of(const orbident_robot& robot, const Joint* joints,
                               const Wheel* wheels, const DrivenJoint* driven) {
  const Real* const n = robot.noise;
  const ConservedAxes axes{{robot.momentum[0], robot.momentum[1], robot.momentum[2]},
                           robot.momenta,
                           {robot.velocity[0], robot.velocity[1], robot.velocity[2]},
                           robot.velocities};
  const SensorNoise noise{n[0], n[1], n[2], n[3], n[4],  n[5],
                          n[6], n[7], n[8], n[9], n[10], robot.accelerometer != 0};
  const MinimalSets sets{view(robot.theta_of_linear), view(robot.theta_of_sigma), robot.product,
                         robot.products};
  const ParametersOfBeta of_beta{view(robot.pi_of_shown),
                                 view(robot.pi_of_products),
                                 robot.pair,
                                 robot.pis,
                                 robot.sigmas,
                                 robot.iotas};
  const Tree tree{joints, robot.joints};
  return {{{tree, nullptr, nullptr, wheels, robot.wheels},
           sets,
           view(robot.theta_of_beta),
           axes,
           noise,
           {driven, robot.driven_joints, robot.longest}},
          of_beta};
}

// So many objects in the caller's numbers. Eigen's small matrices are numbers and nothing else.
template <class T>
constexpr T* objects(Memory& memory, int count) {
  // A joint has two whole numbers beside its 33 numbers, and a driven one one beside 12: as much
  // with float as with double.
  constexpr int EACH = sizeof(T) % sizeof(Real) == 0 && sizeof(T) / sizeof(Real) < 33
                           ? static_cast<int>(sizeof(T) / sizeof(Real))
                           : 35;
  static_assert(sizeof(T) <= EACH * sizeof(Real) && alignof(T) <= alignof(Real));
  Real* const part = memory.take(count, EACH);
  if (!part) return nullptr;
  return reinterpret_cast<T*>(part);
}

struct Layout {
  FilterSizes size;
  Real* mark;   // of the table: negative once the filter has diverged
  Real* t;      // of an innovation that the detector has not seen yet, s; else NaN
  Real* white;  // the last innovation
  FilterState filter;
  Watch watch;
  long summed;     // numbers so far, of which the checksum is
  Real* checksum;  // of a copy
  long carried;    // numbers so far
  Joint* joint;
  Wheel* wheel;
  DrivenJoint* driven;
  FilterRoom room;
  Real* opening;
  long all;
};

constexpr Layout layout(const FilterModel& model, int window, Real* first) {
  Memory memory{first};
  const FilterSizes size = model.sizes();
  const Robot& robot = model.laws.robot;
  const int bodies = robot.tree.bodies();
  Layout at{};
  at.size = size;
  at.mark = memory.take(1);
  at.t = memory.take(1);
  at.white = memory.take(size.rows);
  at.filter = state_in(size, memory);
  at.watch = {size.rows, window, nullptr, nullptr};
  at.watch.sums = memory.take(window + 1, size.rows);
  at.watch.times = memory.take(window + 1);
  at.summed = memory.used;
  at.checksum = memory.take(2);
  at.carried = memory.used;
  at.joint = objects<Joint>(memory, robot.tree.joints);
  at.wheel = objects<Wheel>(memory, robot.wheels);
  at.driven = objects<DrivenJoint>(memory, size.driven);
  Bodies<Real> of{};
  of.pose = objects<Pose<Real>>(memory, bodies);
  of.field = objects<Motion<Real>>(memory, bodies);
  of.motion = objects<Motion<Real>>(memory, bodies);
  of.rate = nullptr;  // of the equations of motion, which the filter does not need
  of.mass = objects<Mass<Real>>(memory, bodies);
  of.carried = objects<Mass<Real>>(memory, bodies);
  of.momentum = objects<Momentum<Real>>(memory, bodies);
  at.room = room_in(model, of, memory);
  at.opening = memory.take(1, 0);
  memory.used += opening_numbers(size);
  at.all = memory.used;
  return at;
}

constexpr Layout layout(const orbident_robot& robot, Real* first) {
  return layout(model_of(robot, nullptr, nullptr, nullptr), robot.window, first);
}

// The tables that are made of the constant one, and room that begins with zeros.
inline void prepare(const orbident_robot& robot, Real* memory, const Layout& at) {
  for (long i = at.carried; i < at.all; ++i) memory[i] = 0;
  for (int k = 0; k < robot.joints; ++k) {
    const orbident_joint& j = robot.joint[k];
    const Matrix R_PJ = Eigen::Map<const Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>>(j.R_PJ);
    new (at.joint + k) Joint(j.parent, j.revolute != 0, Vector(j.axis[0], j.axis[1], j.axis[2]),
                             R_PJ, Vector(j.p_PJ[0], j.p_PJ[1], j.p_PJ[2]));
  }
  for (int k = 0; k < robot.wheels; ++k) {
    const orbident_wheel& w = robot.wheel[k];
    new (at.wheel + k) Wheel{Vector(w.axis[0], w.axis[1], w.axis[2]), w.inertia};
  }
  for (int k = 0; k < robot.driven_joints; ++k) {
    const orbident_driven& d = robot.driven[k];
    new (at.driven + k) DrivenJoint{d.joint, d.walk, d.still, {}, {}};
    for (int i = 0; i < DRIVES; ++i) {
      at.driven[k].known[i] = d.known[i];
      at.driven[k].std[i] = d.std[i];
    }
  }
}

}  // namespace orbident::flight
