// What one shooting interval's equations are made of: what was recorded over it, where they are
// linearised, and the table they grow in.
#pragma once

#include "orbident/householder.hpp"
#include "orbident/joint_history.hpp"
#include "orbident/joint_momenta.hpp"
#include "orbident/shooting.hpp"
#include "orbident/whitening.hpp"

namespace orbident {

constexpr int BIASES = 9;  // turn and biases: what goes on from interval to interval

// A sensor's samples, rows x axes; no values where there is no such sensor.
struct Sensed {
  const double* values;
  const double* weights;     // 1 over the noise's std; zero where there was no sample
  double* residuals;         // over the white noise; null where nobody asks
  const Coloured* coloured;  // of each axis; null where the noise is white
  int lasting;               // where the first of its lasting parts is in z
  bool turns;                // attitude: what its rate walks by is the base's own motion

  void keep(std::ptrdiff_t at, double residual) const {
    if (residuals) residuals[at] = residual;
  }
};

// Of what walks, over its density; an interval of one row lasts no time.
inline double walked(double duration) {
  constexpr double MOMENT = 1e-3;
  return std::sqrt(std::max(duration, MOMENT));
}

constexpr int TRACKERS = 2;  // attitude and position: their noise may last

// What holds a joint that nobody measures.
struct Spring {
  int joint;
  int correction;         // which of the joints with corrections it is
  double square;          // r^2, rad^2/s^2
  double damping;         // d, 1/s
  double walk[2];         // what else moves its position and rate, per square root of a second
  const double* carried;  // I by each entry of theta
};

// What a joint's motor and friction are taken to have, before errors of these.
struct DrivenJoint {
  double armature, viscous, coulomb, offset;  // A, d, c, o of joint_torques.hpp
};

// Right-hand sides of recordings that differ a little, as `right_hand_sides` has them.
struct Changes {
  int count = 0;
  const double* const* sides = nullptr;   // of each
  const double* sizes = nullptr;          // what each recording was changed by
  const std::ptrdiff_t* first = nullptr;  // intervals: where the sides of each begin
};

struct Recorded {
  Tree tree;
  Sparse theta_of;  // theta = theta_0 + theta_of beta, where theta_0 has no beta
  bool planar;
  int substeps;          // of the attitude, from row to row
  const int* corrected;  // joints that have corrections
  Followers followers;
  int wheels;
  IntervalColumns columns;
  int rows;
  const double* t;  // rows, s
  const int* edge;  // intervals + 1: the first row of each, and `rows`
  int intervals;
  JointHistory history;
  const double* A_rw;  // wheels x 3: a_i I_i, base axes
  const Spring* spring;
  int springs;
  // At 2 rows - 1 nodes: every row, and half-way between.
  Acting acting;
  Sensed gyro, accelerometer, attitude, joints, position, velocity;
  Sensed torques;                // of joints: at the first row of an interval, the mean over it
  const DrivenJoint* driven;     // joints
  const double* over_intervals;  // intervals x joints x 2: of torques, mean of the rate's sign,
                                 // and by how much they change, over its length, N m/s
  int lasting;   // parts of the trackers' noise that last, and a momentum that walks
  int momentum;  // where it is in z: how far that of a planar robot walked; -1 if it does not
  // How freely the unknowns of boundaries vary: standard deviations.
  const double* first;  // of z at the first row
  const double* prior;  // of corrections anywhere
  const double* walk;   // of turn and biases, per square root of a second
  Changes changes;

  bool passive(int joint) const {
    for (int k = 0; k < springs; ++k)
      if (spring[k].joint == joint) return true;
    return false;
  }
  // Whether joints' own equations are among those of an interval.
  bool own() const { return springs > 0 || torques.values; }
  int corrections() const { return BIASES + lasting; }  // where they begin in z
  int local() const { return corrections() + 2 * columns.corrected; }
  int common() const { return columns.common(); }
  CalibrationPlaces places() const { return {tree.joints, wheels}; }
  // Beside the right-hand side, changes have columns as unknowns have.
  int sides() const { return changes.count + 1; }
  int width() const { return 2 * local() + common() + sides(); }
  int stride() const { return padded(width()); }
};

// Where the equations are linearised.
struct LinearisedAt {
  const double* x_WB;   // boundaries x 4
  const double* local;  // boundaries x local; turns are zero
  const double* common;
  const double* theta;  // of its beta
  Calibration calibration;
};

// A joint's motor and friction as they are now.
struct Drive {
  double scale, armature, viscous, coulomb, offset;
  Drive(const Recorded& recorded, const Calibration& calibration, int joint) {
    const DrivenJoint& own = recorded.driven[joint];
    const double* x = calibration.values + joint;
    scale = x[calibration.places.torque_scale()];
    armature = own.armature + x[calibration.places.armature()];
    viscous = own.viscous + x[calibration.places.viscous()];
    coulomb = own.coulomb + x[calibration.places.coulomb()];
    offset = own.offset + x[calibration.places.offset()];
  }
};

// Passive joints at a node; passive_rates.hpp.
struct PassiveNode {
  double *q, *qd, *qdd, *p, *p_rate;  // passive joints each
  double *UH, *A;
};

struct PassiveMemory {
  DirectionPlaces places;
  JointMomentaMemory at;
  Motion<double>* geometry;      // fields of the calibrations of geometry
  const int *displaced, *place;  // their joints and their places
  double *m, *D_qq, *inertia, *U, *H, *L, *C, *K, *last;
  double* rates;                       // of RK4: 8 x passive joints
  double *impulse, *impulse_by, *row;  // joint_torques.hpp: joints, x unknowns, and one row
  JointNode joints[2];                 // half-way through a step, and at its end
};

struct IntervalMemory {
  TermsMemory terms;
  PassiveMemory own;
  JointState after[2];  // what joints show at the two nodes after one, or before the last
  int knot = 0;         // the last one before a node
  JointNode node[3];
  BaseNode base[3];
  double* velocity[3];  // 3 x unknowns each
  double* slopes;       // 3 x unknowns
  double* felt;         // 3 x unknowns
  double* moved;        // 3 x unknowns
  Whitening whitening[TRACKERS][3];
};

// A table of equations that grows row by row.
struct EquationTable {
  double* table;
  int stride, width;
  int start, end;  // columns of z at the interval's start and end
  int local;
  int corrections;  // where they begin in z
  int momentum;     // where it is in z, or -1
  int rows;
  double cost;

  double* empty() {
    double* row = table + std::ptrdiff_t(rows++) * stride;
    std::fill_n(row, stride, 0.0);
    return row;
  }

  double* add(double right_hand_side) {
    double* row = empty();
    row[width - 1] = right_hand_side;
    cost += right_hand_side * right_hand_side;
    return row;
  }

  // From slopes by the interval's unknowns.
  double* add(const IntervalColumns& c, const double* slopes, double weight, double error) {
    double* row = add(weight * error);
    write(c, slopes, weight, row);
    return row;
  }

  void write(const IntervalColumns& c, const double* slopes, double weight, double* row) const {
    const auto scaled = [&](int from, int count, double* to) {
      for (int k = 0; k < count; ++k) to[k] = weight * slopes[from + k];
    };
    scaled(c.turn(), 3, row + start);
    // It adds to the one that all intervals have in common.
    if (momentum >= 0) scaled(c.outside() + 2, 1, row + start + momentum);
    scaled(c.corrections(), 2 * c.corrected, row + start + corrections);
    scaled(c.corrections() + 2 * c.corrected, 2 * c.corrected, row + end + corrections);
    scaled(c.outside(), c.common(), row + 2 * local);
  }

  // The row over the deviation of what it says.
  void scale(double deviation, double* row) {
    for (int k = 0; k < width; ++k) row[k] /= deviation;
    cost += row[width - 1] * row[width - 1];
  }
};

}  // namespace orbident
