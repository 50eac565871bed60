/* Replays a recording: takes its samples in one by one, as flight software would, and compares
 * every estimate with Python's. Ends with 0 only where all agree to the last bit; with float, which
 * cannot, where no step failed: then it prints by how much the estimates are off. */
#include <math.h>
#include <stdio.h>

#include "golden.h"
#include "robot.h"

static orbident_real memory[ROBOT_MEMORY];

static int failed(const char* call, int code) {
  printf("%s: code %d\n", call, code);
  return 1;
}

/* The largest error of the estimate, over its deviation. */
static double error_of(const orbident_real* beta, const double* expected) {
  static orbident_real std[ROBOT_BETAS];
  double largest = 0.0;
  int i;
  orbident_get(&ROBOT, memory, ORBIDENT_DEVIATIONS, std, ROBOT_BETAS);
  for (i = 0; i < ROBOT_BETAS; ++i) {
    const double error = fabs((double)beta[i] - expected[i]) / (double)std[i];
    if (!(error <= largest)) largest = error;
  }
  return largest;
}

int main(void) {
  const int exact = sizeof(orbident_real) == sizeof(double);
  static orbident_real sample[ROBOT_MEASURED], beta[ROBOT_BETAS];
  orbident_detection detection;
  orbident_real t;
  int k, i, code, agree = 0, changes = 0;
  for (k = 0; k < GOLDEN_STEPS; ++k) {
    const double* const expected = GOLDEN_BETA + (long)k * ROBOT_BETAS;
    int same = 1;
    for (i = 0; i < ROBOT_MEASURED; ++i)
      sample[i] = (orbident_real)GOLDEN_SAMPLE[(long)k * ROBOT_MEASURED + i];
    if (k == 0) {
      code = orbident_init(&ROBOT, memory, ROBOT_MEMORY, sample, GOLDEN_MOMENTUM);
      if (code < 0) return failed("orbident_init", code);
    }
    /* A float has no digits left for what passed before the recording. */
    t = (orbident_real)(exact ? GOLDEN_TIME[k] : GOLDEN_TIME[k] - GOLDEN_TIME[0]);
    code = orbident_step(&ROBOT, memory, t, sample);
    if (code == ORBIDENT_DIVERGED) return failed("orbident_step", code);
    detection.statistic = 0; /* where the sample does not count */
    code = orbident_detect(&ROBOT, memory, &detection);
    orbident_get(&ROBOT, memory, ORBIDENT_BETA, beta, ROBOT_BETAS);
    for (i = 0; i < ROBOT_BETAS; ++i) same &= (double)beta[i] == expected[i];
    same &= (double)detection.statistic == GOLDEN_STATISTIC[k];
    agree += same;
    if (!exact && (k + 1) * 8 / GOLDEN_STEPS > k * 8 / GOLDEN_STEPS)
      printf("t = %.4g s: off by at most %.2g of a deviation\n", GOLDEN_TIME[k],
             error_of(beta, expected));
    if (code != ORBIDENT_CHANGED) continue;
    ++changes;
    code = orbident_open(&ROBOT, memory, t);
    if (code < 0) return failed("orbident_open", code);
  }
  printf("%d of %d steps agree to the last bit; changes of the robot: %d\n", agree, GOLDEN_STEPS,
         changes);
  return exact && agree < GOLDEN_STEPS;
}
