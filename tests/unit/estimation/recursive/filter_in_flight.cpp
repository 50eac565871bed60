// The recursive filter as a flight computer runs it: constant tables, static memory, no heap.
// Prints beta after each sample, then g of the change detector, as hexadecimal floats.
#define EIGEN_NO_MALLOC

#include <cmath>
#include <cstdio>

#include "orbident/change_detection.hpp"
#include "orbident/information_filter.hpp"

namespace {

using namespace orbident;

// TREE, THETA, WHEELS, the sparse matrices, SAMPLES and the sizes: constants of one robot.
#include "tables.inc"

Pose<double> poses[BODIES];
Motion<double> fields[BODIES], motions[BODIES], rates[BODIES];
Mass<double> masses[BODIES], carried[BODIES];
Momentum<double> momenta[BODIES];
double memory[DOUBLES];
double sums[(WINDOW + 1) * 6], times[WINDOW + 1];

}  // namespace

int main() {
  const Bodies<double> bodies{poses, fields, motions, rates, masses, carried, momenta};
  Memory free{memory};
  FilterState state = state_in(MODEL.sizes(), free);
  FilterRoom room = room_in(MODEL, bodies, free);
  if (free.used > DOUBLES) return 1;
  Watch watch{MODEL.sizes().rows, WINDOW, sums, times};
  watch_nothing(watch);
  start(MODEL, PRIOR_BETA, PRIOR_ROOT, SAMPLES, nullptr, state, room);
  for (int k = 0; k < COUNT; ++k) {
    const Innovation innovation = step(MODEL, state, TIMES[k], SAMPLES + k * MEASURED, room);
    const Likelihood most = watch_one(watch, TIMES[k], innovation.white, innovation.stride);
    for (int i = 0; i < MODEL.sizes().betas(); ++i) std::printf("%a ", state.beta[i]);
    std::printf("%a\n", most.g);
  }
  return 0;
}
