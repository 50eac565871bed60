// Least squares over a chain of shooting intervals, as square-root information (Bierman, 1977).
//
// Each interval's equations hold the unknowns of its two boundaries and g, those that all have in
// common. Folding them into what is known so far, with the boundary that was reached on the left,
//
//   [z near | z far | g | changes | right-hand side]
//
// leaves rows that give z near once the others are known, the links, and below them all that is
// known of z far and g. The chain is eliminated from both ends at once; both meet at a boundary in
// its middle. So two threads have half of it each, and the sums are the same on one thread.
//
// Continuity and priors weigh up to 1e13 times as much as sensors: they come into the factor first.
#pragma once

#include "orbident/encoders.hpp"

namespace orbident {

inline int meeting_boundary(int intervals) { return intervals / 2; }

// The caller's memory for one of the two ends; n = recorded.stride().
struct SweepMemory {
  IntervalMemory interval;
  double* R;           // width x n; at last what is known of [z near | z far, empty | g | rhs]
  double* known;       // local x n: rows over [z near | z far, empty | g | rhs]
  double* rows;        // as many as an interval's samples have axes, and lasting noise x n
  double* continuity;  // BIASES, and two of each joint's own equation x n
  double* encoders;    // joint_width + BLOCK rows x joint_width

  EquationTable sensed(const Recorded& recorded, bool forward) const {
    return table(recorded, forward, rows);
  }
  EquationTable continued(const Recorded& recorded, bool forward) const {
    return table(recorded, forward, continuity);
  }

 private:
  static EquationTable table(const Recorded& recorded, bool forward, double* to) {
    const int L = recorded.local(), start = forward ? 0 : L;
    return {to, recorded.stride(),      recorded.width(),  start, L - start,
            L,  recorded.corrections(), recorded.momentum, 0,     0.0};
  }
};

// Columns of changes: by how much their right-hand sides differ; `side` is where the rows begin.
inline void add_changes(const Changes& changes, std::ptrdiff_t side, EquationTable& equations) {
  for (int k = 0; changes.count && k < equations.rows; ++k, ++side) {
    double* const right_hand_side =
        equations.table + std::ptrdiff_t(k) * equations.stride + equations.width - 1;
    for (int j = 0; j < changes.count; ++j)
      right_hand_side[j - changes.count] =
          (*right_hand_side - changes.sides[j][side]) / changes.sizes[j];
  }
}

// Eliminates the boundaries from one end up to the meeting one, and returns the cost. `links`:
// intervals x local x width; null where nobody asks.
inline double sweep(const Recorded& recorded, const LinearisedAt& at, bool forward,
                    SweepMemory& memory, double* links) {
  const int L = recorded.local(), width = recorded.width(), n = recorded.stride();
  const int meeting = meeting_boundary(recorded.intervals);
  const int begin = forward ? 0 : recorded.intervals - 1, stop = forward ? meeting : meeting - 1,
            on = forward ? 1 : -1;
  double cost = 0.0;
  std::fill_n(memory.R, std::ptrdiff_t(width) * n, 0.0);
  std::fill_n(memory.known, std::ptrdiff_t(L) * n, 0.0);
  for (int k = 0; forward && k < L; ++k) {
    double* row = memory.known + std::ptrdiff_t(k) * n;
    row[k] = 1 / recorded.first[k];
    row[width - 1] = -at.local[k] / recorded.first[k];
    cost += row[width - 1] * row[width - 1];
  }
  for (int interval = begin; interval != stop; interval += on) {
    EquationTable sensed = memory.sensed(recorded, forward),
                  continuity = memory.continued(recorded, forward);
    linearise(recorded, at, interval, memory.interval, sensed, continuity);
    const Changes& changes = recorded.changes;
    const std::ptrdiff_t side = changes.count ? changes.first[interval] : 0;
    add_changes(changes, side, sensed);
    add_changes(changes, side + sensed.rows, continuity);
    std::fill_n(memory.R, std::ptrdiff_t(2 * L) * n, 0.0);
    fold(memory.R, n, continuity.table, n, BIASES, n, BIASES);
    cost += sensed.cost + continuity.cost +
            add_encoders(recorded, at, interval, forward, side + sensed.rows + continuity.rows,
                         memory.encoders, memory.R);
    fold(memory.R, n, continuity.table + std::ptrdiff_t(BIASES) * n, n, continuity.rows - BIASES, n,
         width);
    fold(memory.R, n, memory.known, n, L, n, width);
    fold(memory.R, n, sensed.table, n, sensed.rows, n, width);
    for (int k = 0; k < L; ++k) {
      if (links)
        std::copy_n(memory.R + std::ptrdiff_t(k) * n, width,
                    links + (std::ptrdiff_t(interval) * L + k) * width);
      // What is known of z far, as the next interval's z near.
      const double* row = memory.R + std::ptrdiff_t(L + k) * n;
      double* known = memory.known + std::ptrdiff_t(k) * n;
      std::copy_n(row + L, L, known);
      std::fill_n(known + L, L, 0.0);
      std::copy_n(row + 2 * L, n - 2 * L, known + 2 * L);
    }
  }
  // At the meeting boundary: z near alone.
  std::fill_n(memory.R, std::ptrdiff_t(2 * L) * n, 0.0);
  fold(memory.R, n, memory.known, n, L, n, width);
  return cost;
}

// The factor over [z | g | rhs] of the meeting boundary, from both ends' R; `backward` is used up.
inline void join(const Recorded& recorded, SweepMemory& forward, SweepMemory& backward,
                 double* factor) {
  const int L = recorded.local(), width = recorded.width(), n = recorded.stride();
  fold(forward.R, n, backward.R, n, width, n, width);
  const int left = width - L;
  for (int k = 0; k < left; ++k) {
    const double* row = forward.R + std::ptrdiff_t(k < L ? k : L + k) * n;
    double* to = factor + std::ptrdiff_t(k) * left;
    std::copy_n(row, L, to);
    std::copy_n(row + 2 * L, left - L, to + L);
  }
}

// z of the boundary at the near side of a link, once z far and g are known.
inline void follow(const double* link, int local, int width, const double* far, const double* g,
                   double* near) {
  for (int k = local - 1; k >= 0; --k) {
    const double* row = link + std::ptrdiff_t(k) * width;
    double left = row[width - 1];
    for (int j = k + 1; j < local; ++j) left -= row[j] * near[j];
    for (int j = 0; j < local; ++j) left -= row[local + j] * far[j];
    for (int j = 2 * local; j < width - 1; ++j) left -= row[j] * g[j - 2 * local];
    near[k] = left / row[k];
  }
}

// z of every boundary, from that of the meeting one and g.
inline void boundaries(const double* links, int intervals, int local, int width, const double* g,
                       double* z) {
  const int meeting = meeting_boundary(intervals);
  const std::ptrdiff_t size = std::ptrdiff_t(local) * width;
  for (int k = meeting - 1; k >= 0; --k)
    follow(links + k * size, local, width, z + (k + 1) * local, g, z + k * local);
  for (int k = meeting; k < intervals; ++k)
    follow(links + k * size, local, width, z + k * local, g, z + (k + 1) * local);
}

}  // namespace orbident
