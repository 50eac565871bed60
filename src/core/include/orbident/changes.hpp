// What recordings that differ a little from another one would leave: columns beside its unknowns.
//
// If a recording changed by c leaves e(c) of what the sensors showed, e is linear in a small c:
//
//   e(0) = slopes x change of the unknowns + (e(0) - e(c)) / c x change of c
//
// so that one elimination shows what the unknowns would follow, and what is left for each change.
#pragma once

#include <vector>

#include "orbident/elimination.hpp"

namespace orbident {

// The right-hand sides of all intervals, one after another: of sensors, of continuity and, row by
// row, of the encoders. Returns where those of each interval begin.
inline std::vector<std::ptrdiff_t> right_hand_sides(const Recorded& recorded,
                                                    const LinearisedAt& at, SweepMemory& memory,
                                                    std::vector<double>& sides) {
  const int K = recorded.tree.joints, last = recorded.width() - 1, n = recorded.stride();
  std::vector<std::ptrdiff_t> begin;
  for (int interval = 0; interval < recorded.intervals; ++interval) {
    begin.push_back(static_cast<std::ptrdiff_t>(sides.size()));
    EquationTable sensed = memory.sensed(recorded, true),
                  continuity = memory.continued(recorded, true);
    linearise(recorded, at, interval, memory.interval, sensed, continuity);
    for (const EquationTable* each : {&sensed, &continuity})
      for (int k = 0; k < each->rows; ++k)
        sides.push_back(each->table[std::ptrdiff_t(k) * n + last]);
    for (int r = recorded.edge[interval]; recorded.joints.values && r < recorded.edge[interval + 1];
         ++r) {
      const Cubics functions = functions_at(recorded, interval, r);
      for (int k = 0, c = 0, knot = 0; k < K; ++k) {
        const bool corrected = c < recorded.columns.corrected && recorded.corrected[c] == k;
        sides.push_back(
            encoder_error(recorded, at, interval, r, k, corrected ? c++ : -1, functions, knot));
      }
    }
  }
  begin.push_back(static_cast<std::ptrdiff_t>(sides.size()));
  return begin;
}

}  // namespace orbident
