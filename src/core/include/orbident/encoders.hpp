// What the encoders and the prior say of the corrections of each joint: rows over the four
// functions of a cubic, joint by joint, so that a small triangle holds all rows of an interval.
#pragma once

#include "orbident/interval.hpp"

namespace orbident {

constexpr int FUNCTIONS = 4;
// Numbers of a row: the functions, changes and the right-hand side.
inline int joint_width(const Recorded& recorded) { return padded(FUNCTIONS + recorded.sides()); }

// The four functions of an interval's corrections at a row.
inline Cubics functions_at(const Recorded& recorded, int interval, int row) {
  const int first = recorded.edge[interval];
  const int end = std::min(recorded.edge[interval + 1], recorded.rows - 1);
  return cubics(recorded.t[row] - recorded.t[first], recorded.t[end] - recorded.t[first]);
}

// What an encoder showed beside what the joint's history and its corrections say, over the noise.
// `c`: which of the joints with corrections it is, or -1.
inline double encoder_error(const Recorded& recorded, const LinearisedAt& at, int interval, int row,
                            int joint, int c, const Cubics& functions, int& knot) {
  const int K = recorded.tree.joints, C = recorded.columns.corrected, L = recorded.local();
  const JointHistory& history = recorded.history;
  knot = history.knot(recorded.t[row], knot);
  double error = recorded.joints.values[row * K + joint] -
                 history.between(history.functions(recorded.t[row], knot).value, history.q[joint],
                                 history.q_slope[joint], knot);
  for (int f = 0; c >= 0 && f < FUNCTIONS; ++f)
    error -= functions.value[f] *
             at.local[(interval + f / 2) * L + recorded.corrections() + f % 2 * C + c];
  return recorded.joints.weights[row * K + joint] * error;
}

// Writes each joint's triangle into R, over [z near | z far | g | changes | right-hand side], whose
// rows and columns of the corrections are empty; what no correction explains is folded into R's
// last rows. `side`: where the encoders' rows of this interval are in those of each change. Returns
// the sum of squared residuals.
inline double add_encoders(const Recorded& recorded, const LinearisedAt& at, int interval,
                           bool start_near, std::ptrdiff_t side, double* memory, double* R) {
  const int K = recorded.tree.joints, C = recorded.columns.corrected, L = recorded.local();
  const int first = recorded.edge[interval], last = recorded.edge[interval + 1];
  const int stride = recorded.stride(), sides = recorded.sides(), from = recorded.width() - sides;
  const int n = joint_width(recorded), width = FUNCTIONS + sides;
  const Changes& changes = recorded.changes;
  double* const triangle = memory;
  double* const rows = memory + std::ptrdiff_t(n) * n;
  double cost = 0.0;
  for (int k = 0, c = 0; k < K; ++k) {
    const bool corrected = c < C && recorded.corrected[c] == k;
    std::fill_n(triangle, std::ptrdiff_t(n) * n, 0.0);
    int count = 0;
    const auto folded = [&] {
      fold(triangle, n, rows, n, count, n, width);
      count = 0;
    };
    const auto add = [&](double error) {
      if (count == BLOCK) folded();
      double* row = rows + std::ptrdiff_t(count++) * n;
      std::fill_n(row, n, 0.0);
      row[width - 1] = error;
      cost += error * error;
      return row;
    };
    for (int r = first, knot = 0; recorded.joints.values && r < last; ++r) {
      const Cubics functions = functions_at(recorded, interval, r);
      const double error =
          encoder_error(recorded, at, interval, r, k, corrected ? c : -1, functions, knot);
      recorded.joints.keep(r * K + k, error);
      const double weight = recorded.joints.weights[r * K + k];
      if (weight == 0.0) continue;
      double* row = add(error);
      for (int f = 0; corrected && f < FUNCTIONS; ++f)
        row[start_near ? f : (f + 2) % FUNCTIONS] = weight * functions.value[f];
      for (int j = 0; j < changes.count; ++j)
        row[FUNCTIONS + j] =
            (error - changes.sides[j][side + (r - first) * K + k]) / changes.sizes[j];
    }
    for (int f = 0; corrected && f < 2; ++f) {
      const double weight = 1 / recorded.prior[f * C + c];
      double* row =
          add(-weight * at.local[(interval + 1) * L + recorded.corrections() + f * C + c]);
      row[start_near ? 2 + f : f] = weight;
    }
    folded();
    fold(R + std::ptrdiff_t(from) * stride + from, stride,
         triangle + std::ptrdiff_t(FUNCTIONS) * n + FUNCTIONS, n, sides, sides, sides);
    if (!corrected) continue;
    const auto place = [&](int f) { return f / 2 * L + recorded.corrections() + f % 2 * C + c; };
    for (int f = 0; f < FUNCTIONS; ++f) {
      double* row = R + std::ptrdiff_t(place(f)) * stride;
      for (int other = f; other < FUNCTIONS; ++other) row[place(other)] = triangle[f * n + other];
      std::copy_n(triangle + std::ptrdiff_t(f) * n + FUNCTIONS, sides, row + from);
    }
    ++c;
  }
  return cost;
}

}  // namespace orbident
