// What the encoders and the prior say of the corrections of each joint: rows over the four
// functions of a cubic, joint by joint, so that a small triangle holds all rows of an interval.
#pragma once

#include "orbident/interval.hpp"

namespace orbident {

constexpr int FUNCTIONS = 4;
// Of a row: the functions and the right-hand side.
constexpr int JOINT_WIDTH = padded(FUNCTIONS + 1);

// Writes each joint's triangle into R, over [z near | z far | g | right-hand side], whose rows and
// columns of the corrections are empty; what no correction explains adds to R's last entry. Returns
// the sum of squared residuals.
inline double add_encoders(const Recorded& recorded, const LinearisedAt& at, int interval,
                           bool start_near, double* R) {
  const int K = recorded.tree.joints, C = recorded.columns.corrected, L = recorded.local();
  const int first = recorded.edge[interval], last = recorded.edge[interval + 1];
  const int end = std::min(last, recorded.rows - 1);
  const double duration = recorded.t[end] - recorded.t[first];
  const int stride = recorded.stride(), right_hand_side = recorded.width() - 1;
  const auto corrections = [&](int boundary) {
    return at.local + boundary * L + recorded.corrections();
  };
  double cost = 0.0, left = 0.0, rows[BLOCK * JOINT_WIDTH];
  for (int k = 0, c = 0; k < K; ++k) {
    const bool corrected = c < C && recorded.corrected[c] == k;
    const double before = cost;
    double triangle[JOINT_WIDTH * JOINT_WIDTH] = {};
    int count = 0;
    const auto folded = [&] {
      fold(triangle, JOINT_WIDTH, rows, JOINT_WIDTH, count, JOINT_WIDTH, FUNCTIONS + 1);
      count = 0;
    };
    const auto add = [&](double error) {
      if (count == BLOCK) folded();
      double* row = rows + count++ * JOINT_WIDTH;
      std::fill_n(row, JOINT_WIDTH, 0.0);
      row[FUNCTIONS] = error;
      cost += error * error;
      return row;
    };
    const JointHistory& history = recorded.history;
    for (int r = first, knot = 0; recorded.joints.values && r < last; ++r) {
      const double weight = recorded.joints.weights[r * K + k];
      knot = history.knot(recorded.t[r], knot);
      const Cubics functions = cubics(recorded.t[r] - recorded.t[first], duration);
      double error = recorded.joints.values[r * K + k] -
                     history.between(history.functions(recorded.t[r], knot).value, history.q[k],
                                     history.q_slope[k], knot);
      for (int f = 0; corrected && f < FUNCTIONS; ++f)
        error -= functions.value[f] * corrections(interval + f / 2)[f % 2 * C + c];
      recorded.joints.keep(r * K + k, weight * error);
      if (weight == 0.0) continue;
      double* row = add(weight * error);
      for (int f = 0; f < FUNCTIONS; ++f)
        row[start_near ? f : (f + 2) % FUNCTIONS] = weight * functions.value[f];
    }
    if (!corrected) {
      left += cost - before;
      continue;
    }
    for (int f = 0; f < 2; ++f) {
      const double weight = 1 / recorded.prior[f * C + c];
      double* row = add(-weight * corrections(interval + 1)[f * C + c]);
      row[start_near ? 2 + f : f] = weight;
    }
    folded();
    left += triangle[FUNCTIONS * JOINT_WIDTH + FUNCTIONS] *
            triangle[FUNCTIONS * JOINT_WIDTH + FUNCTIONS];
    const auto place = [&](int f) { return f / 2 * L + recorded.corrections() + f % 2 * C + c; };
    for (int f = 0; f < FUNCTIONS; ++f) {
      double* row = R + std::ptrdiff_t(place(f)) * stride;
      for (int other = f; other < FUNCTIONS; ++other)
        row[place(other)] = triangle[f * JOINT_WIDTH + other];
      row[right_hand_side] = triangle[f * JOINT_WIDTH + FUNCTIONS];
    }
    ++c;
  }
  double& last_entry = R[std::ptrdiff_t(right_hand_side) * stride + right_hand_side];
  last_entry = std::sqrt(last_entry * last_entry + left);
  return cost;
}

}  // namespace orbident
