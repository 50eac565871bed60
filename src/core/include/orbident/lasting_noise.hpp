// What lasts of the noise of attitude and position, over one shooting interval.
//
// Its value x where the interval begins is an unknown, as biases are. From there on the filter of
// whitening.hpp runs with rows for means, linear in all unknowns of the interval: samples become
// their innovations, and at the end
//
//   x at the next interval's start - x as the filter has it ~ N(0, P)
//
// This is exact: what is eliminated inside the interval is Gaussian, and linear in the samples.
//
// Where the rate of a planar base walks, it turns by it: both parts are zero where an interval
// begins, and where it ends the next one's attitude and momentum have them,
//
//   E (h at the next start - h),  turn at the next start - that at the end ~ N(0, P)
#pragma once

#include "orbident/interval_tables.hpp"

namespace orbident {

// x = local + change, as a row: a value, and slopes to be subtracted.
inline void start_lasting(const Recorded& recorded, const LinearisedAt& at, int interval,
                          const Sensed& sensor, Whitening* whitening,
                          const EquationTable& equations) {
  if (!sensor.coloured) return;
  const double* here = at.local + interval * recorded.local();
  for (int axis = 0, place = sensor.lasting; axis < 3; ++axis) {
    Whitening& filter = whitening[axis];
    filter.width = equations.width;
    filter.start(sensor.coloured[axis], recorded.t[recorded.edge[interval]]);
    for (int part = 0; part < Coloured::PARTS; ++part) {
      if (!filter.coloured.has(part) || (sensor.turns && part >= OFFSET)) continue;
      filter.mean[part][equations.width - 1] = here[place];
      filter.mean[part][equations.start + place++] = -1.0;
    }
  }
}

inline void end_lasting(const Recorded& recorded, const LinearisedAt& at, int interval, int end,
                        const Sensed& sensor, const BaseNode& stop, Whitening* whitening,
                        EquationTable& equations) {
  if (!sensor.coloured) return;
  // Of a part's own variance, after a second: an interval of one row lasts no time.
  constexpr double LEAST = 1e-9;
  constexpr int PARTS = Coloured::PARTS;
  const double* there = at.local + (interval + 1) * recorded.local();
  const IntervalColumns& c = recorded.columns;
  const Vector3<double> off = small_rotation<double>(
      Eigen::Map<const Quaternion<double>>(at.x_WB + 4 * (interval + 1)), stop.x_WB);
  for (int axis = 0, place = sensor.lasting; axis < 3; ++axis) {
    Whitening& filter = whitening[axis];
    const Coloured& noise = filter.coloured;
    filter.predict(recorded.t[end]);
    const double least[PARTS] = {LEAST * noise.std * noise.std, LEAST * noise.walk * noise.walk,
                                 LEAST * noise.rate_walk * noise.rate_walk,
                                 LEAST * noise.rate_walk * noise.rate_walk};
    // Cholesky's factor of P, row by row.
    double L[PARTS][PARTS] = {};
    const double* done[PARTS] = {};
    for (int i = 0; i < PARTS; ++i) {
      if (!noise.has(i)) continue;
      double* row = equations.empty();
      if (sensor.turns && i == OFFSET) {
        equations.write(c, stop.phi + axis * c.count(), 1.0, row);
        row[equations.width - 1] = -off[axis];
        row[equations.end + axis] = -1.0;
      } else if (sensor.turns && i > OFFSET) {
        const double E = stop.E(2, 2);
        const double* here = there - recorded.local();
        const double walked = there[recorded.momentum] - here[recorded.momentum];
        constexpr int D_ZZ = BY_D + 5;
        equations.write(c, stop.by + D_ZZ * c.count(), walked * E * E, row);
        row[equations.width - 1] = E * walked;
        row[equations.start + recorded.momentum] += E;
        row[equations.end + recorded.momentum] -= E;
      } else {
        row[equations.width - 1] = there[place];
        row[equations.end + place++] = -1.0;
      }
      for (int k = 0; k < equations.width; ++k) row[k] -= filter.mean[i][k];
      double left = filter.P[i][i];
      for (int j = 0; j < i; ++j) {
        if (!noise.has(j)) continue;
        L[i][j] = filter.P[i][j];
        for (int k = 0; k < j; ++k) L[i][j] -= L[i][k] * L[j][k];
        L[i][j] /= L[j][j];
        left -= L[i][j] * L[i][j];
        for (int k = 0; k < equations.width; ++k) row[k] -= L[i][j] * done[j][k];
      }
      L[i][i] = std::sqrt(std::max(left, least[i]));
      equations.scale(L[i][i], row);
      done[i] = row;
    }
  }
}

}  // namespace orbident
