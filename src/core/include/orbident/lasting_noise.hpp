// What lasts of the noise of attitude and position, over one shooting interval.
//
// Its value x where the interval begins is an unknown, as biases are. From there on the filter of
// whitening.hpp runs with rows for means, linear in all unknowns of the interval: samples become
// their innovations, and at the end
//
//   x at the next interval's start - x as the filter has it ~ N(0, P)
//
// This is exact: what is eliminated inside the interval is Gaussian, and linear in the samples.
#pragma once

#include "orbident/interval_tables.hpp"

namespace orbident {

// x = local + change, as a row: a value, and slopes to be subtracted.
template <class T>
void start_lasting(const Recorded<T>& recorded, const LinearisedAt<T>& at, int interval,
                   const Sensed<T>& sensor, Whitening<T>* whitening,
                   const EquationTable<T>& equations) {
  if (!sensor.coloured) return;
  const T* here = at.local + interval * recorded.local();
  for (int axis = 0, place = sensor.lasting; axis < 3; ++axis) {
    Whitening<T>& filter = whitening[axis];
    filter.width = equations.width;
    filter.start(sensor.coloured[axis], recorded.t[recorded.edge[interval]]);
    for (int part = 0; part < Coloured<T>::PARTS; ++part) {
      if (!filter.coloured.has(part)) continue;
      filter.mean[part][equations.width - 1] = here[place];
      filter.mean[part][equations.start + place++] = T(-1);
    }
  }
}

template <class T>
void end_lasting(const Recorded<T>& recorded, const LinearisedAt<T>& at, int interval, int end,
                 const Sensed<T>& sensor, Whitening<T>* whitening, EquationTable<T>& equations) {
  if (!sensor.coloured) return;
  // Of a part's own variance: an interval of one row lasts no time.
  constexpr double LEAST = 1e-9;
  constexpr int PARTS = Coloured<T>::PARTS;
  const T* there = at.local + (interval + 1) * recorded.local();
  for (int axis = 0, place = sensor.lasting; axis < 3; ++axis) {
    Whitening<T>& filter = whitening[axis];
    const Coloured<T>& noise = filter.coloured;
    filter.predict(recorded.t[end]);
    const T least[PARTS] = {T(LEAST) * noise.std * noise.std, T(LEAST) * noise.walk * noise.walk};
    const T* before = nullptr;
    T root = T(1);
    for (int part = 0; part < PARTS; ++part) {
      if (!noise.has(part)) continue;
      T* row = equations.empty();
      for (int k = 0; k < equations.width; ++k) row[k] = -filter.mean[part][k];
      row[equations.width - 1] += there[place];
      row[equations.end + place++] -= T(1);
      // Cholesky's factor of P, row by row.
      const T across = before ? filter.P[1][0] / root : T(0);
      for (int k = 0; before && k < equations.width; ++k) row[k] -= across * before[k];
      root = std::sqrt(std::max(filter.P[part][part] - across * across, least[part]));
      equations.scale(root, row);
      before = row;
    }
  }
}

}  // namespace orbident
