// What acts on the robot as it moves, such as drag or a thruster: nothing here knows what it is.
//
// At each node a table of what it adds to the motion of the system CM, inertial axes, and to what
// an accelerometer feels of it,
//
//   rows      h_cm 3 | its rate 3 | r_cm 3 | v_cm 3 | felt acceleration 3
//   columns   value | by each gain among the unknowns | by beta, or none where it does not matter
#pragma once

#include "orbident/combined_rows.hpp"
#include "orbident/rotations.hpp"

namespace orbident {

constexpr int ON_H = 0, ON_H_RATE = 3, ON_R = 6, ON_V = 9, ON_FELT = 12, ACTING_ROWS = 15;

// A recording's tables, or the one of a node; without rows nothing acts.
struct Acting {
  const double* rows = nullptr;
  const int* columns = nullptr;  // of the gains among an interval's unknowns
  int gains = 0;
  int beta = 0;  // where the unknowns have it
  int betas = 0;
  int width = 1;

  Acting at(int node) const {
    Acting one = *this;
    if (rows) one.rows += std::ptrdiff_t(node) * ACTING_ROWS * width;
    return one;
  }
  // The three rows from `first` on.
  auto table(int first) const {
    return Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>(
        rows + first * width, 3, width);
  }
  Vector3<double> value(int first) const {
    return rows ? Vector3<double>(table(first).col(0)) : Vector3<double>(Vector3<double>::Zero());
  }
  // Adds `by` times the slopes of these rows.
  template <class Slopes>
  void add(int first, const Matrix3<double>& by, Slopes& slopes) const {
    if (!rows) return;
    // Neighbours among the gains are neighbours among the unknowns, but for a few.
    for (int k = 0, end; k < gains; k = end) {
      for (end = k + 1; end < gains && columns[end] == columns[end - 1] + 1;) ++end;
      add_combined(by, rows + first * width + 1 + k, width, end - k, slopes.data() + columns[k],
                   slopes.cols());
    }
    add_combined(by, rows + first * width + 1 + gains, width, betas, slopes.data() + beta,
                 slopes.cols());
  }
};

}  // namespace orbident
