/* What a flight build has to bear: `flight_checks fuzz N SEED`, `restore N SEED`, `times N`, `refusals`.
 * Ends with 0 if it bears it. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "golden.h"
#include "robot.h"

static orbident_real memory[ROBOT_MEMORY], other[ROBOT_MEMORY], sample[ROBOT_MEASURED];
static orbident_real beta[ROBOT_BETAS], std[ROBOT_BETAS], saved[ROBOT_STATE];
static uint64_t seed;

static double drawn(void) { /* xorshift64*; from 0 to 1 */
  seed ^= seed >> 12, seed ^= seed << 25, seed ^= seed >> 27;
  return (double)((seed * 2685821657736338717ull) >> 11) / 9007199254740992.0;
}

static void read_sample(long k) {
  for (int i = 0; i < ROBOT_MEASURED; ++i)
    sample[i] = (orbident_real)GOLDEN_SAMPLE[k * ROBOT_MEASURED + i];
}

static void begin(orbident_real* array) {
  read_sample(0);
  if (orbident_init(&ROBOT, array, ROBOT_MEMORY, sample, GOLDEN_MOMENTUM) != ORBIDENT_DONE) exit(2);
}

static const double SPOILED[] = {NAN,   INFINITY, -INFINITY, 1e300, -1e300, 1e38, 9e5,
                                 -9e5, 1e5,      0.0,       1e-300, 1e-40, 1.0,  -1.0};

static orbident_real spoil(orbident_real t) {
  const int kinds = (int)(sizeof SPOILED / sizeof *SPOILED);
  const double kind = drawn();
  if (kind < 0.15) return t - (orbident_real)0.1; /* backwards, or repeated */
  if (kind < 0.2) return (orbident_real)SPOILED[(int)(drawn() * kinds)];
  if (kind < 0.22) return t + 1000; /* a gap */
  if (kind < 0.3) {
    for (int i = 0; i < ROBOT_MEASURED; ++i) sample[i] = (orbident_real)SPOILED[(int)(drawn() * kinds)];
    return t;
  }
  for (int i = 1 + (int)(drawn() * 3); i > 0; --i)
    sample[(int)(drawn() * ROBOT_MEASURED)] = (orbident_real)SPOILED[(int)(drawn() * kinds)];
  return t;
}

/* Whether all that a filter says is a number, and every deviation more than none. */
static int sound(int code) {
  orbident_get(&ROBOT, memory, ORBIDENT_BETA, beta, ROBOT_BETAS);
  orbident_get(&ROBOT, memory, ORBIDENT_DEVIATIONS, std, ROBOT_BETAS);
  for (int i = 0; i < ROBOT_BETAS; ++i)
    if (!isfinite(beta[i]) || !isfinite(std[i]) || !(std[i] > 0)) {
      printf("code %d, but parameter %d is %g, its deviation %g\n", code, i, (double)beta[i],
             (double)std[i]);
      return 0;
    }
  return 1;
}

static int fuzz(long steps) {
  long codes[9] = {0}, changes = 0;
  orbident_real t = 0;
  orbident_detection detection;
  begin(memory);
  for (long k = 0; k < steps; ++k) {
    read_sample(k % GOLDEN_STEPS);
    t += (orbident_real)0.1;
    orbident_real at = drawn() < 0.3 ? spoil(t) : t;
    int code = orbident_step(&ROBOT, memory, at, sample);
    ++codes[code < 0 ? -code : 0];
    if (code == ORBIDENT_DIVERGED) {
      if (orbident_get(&ROBOT, memory, ORBIDENT_BETA, beta, ROBOT_BETAS) != code) return 1;
      begin(memory);
      t = 0;
      continue;
    }
    if (!sound(code)) return 1;
    if (drawn() < 0.01) { /* it comes once more, as if later */
      code = orbident_step(&ROBOT, memory, at + (orbident_real)0.01, sample);
      ++codes[code < 0 ? -code : 0];
      if (code == ORBIDENT_DIVERGED) {
        begin(memory);
        t = 0;
        continue;
      }
      if (!sound(code)) return 1;
    }
    if (code == ORBIDENT_NOT_LATER && at == t && orbident_open(&ROBOT, memory, t) != ORBIDENT_DONE)
      begin(memory);
    code = orbident_detect(&ROBOT, memory, &detection);
    if (code >= 0 && (isnan(detection.statistic) || !isfinite(detection.onset))) return 1;
    if (code == ORBIDENT_CHANGED) {
      ++changes;
      if (orbident_open(&ROBOT, memory, at) != ORBIDENT_DONE) begin(memory);
      if (!sound(code)) return 1;
    }
    if (t > 10000) begin(memory), t = 0;
  }
  printf("%ld steps: %ld counted, %ld incomplete, %ld absurd, %ld not later, %ld repeated, "
         "%ld diverged; %ld changes\n",
         steps, codes[0], codes[1], codes[2], codes[3], codes[4], codes[7], changes);
  return 0;
}

/* Power fails at random steps: the state is kept, all else is lost. */
static int restore(long cycles) {
  orbident_real *now = memory, *next = other;
  orbident_detection detection;
  for (long k = 0, done = 0; done < cycles; k = (k + 1) % GOLDEN_STEPS) {
    if (k == 0) begin(now);
    read_sample(k);
    orbident_step(&ROBOT, now, (orbident_real)GOLDEN_TIME[k], sample);
    if (drawn() < 0.3) {
      if (orbident_save(&ROBOT, now, saved) != ORBIDENT_DONE) return 1;
      memset(now, 0xff, sizeof memory);
      memset(next, 0xff, sizeof memory);
      if (orbident_restore(&ROBOT, next, ROBOT_MEMORY, saved) != ORBIDENT_DONE) return 1;
      orbident_real* const before = now;
      now = next, next = before;
      ++done;
    }
    if (orbident_detect(&ROBOT, now, &detection) == ORBIDENT_CHANGED)
      orbident_open(&ROBOT, now, (orbident_real)GOLDEN_TIME[k]);
    orbident_get(&ROBOT, now, ORBIDENT_BETA, beta, ROBOT_BETAS);
    for (int i = 0; i < ROBOT_BETAS; ++i)
      if ((double)beta[i] != GOLDEN_BETA[k * ROBOT_BETAS + i]) return 1;
  }
  printf("%ld restored\n", cycles);
  return 0;
}

static int by_size(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

/* Of all steps, and of each step of the recording in its fastest pass: without what else the machine
 * does meanwhile. */
static int times(long steps) {
  double* const all = malloc(sizeof(double) * (size_t)steps);
  static double least[GOLDEN_STEPS];
  orbident_detection detection;
  for (long k = 0; k < steps; ++k) {
    struct timespec from, to;
    const long row = k % GOLDEN_STEPS;
    if (row == 0) begin(memory);
    read_sample(row);
    clock_gettime(CLOCK_MONOTONIC, &from);
    orbident_step(&ROBOT, memory, (orbident_real)GOLDEN_TIME[row], sample);
    orbident_detect(&ROBOT, memory, &detection);
    clock_gettime(CLOCK_MONOTONIC, &to);
    all[k] = 1e6 * (double)(to.tv_sec - from.tv_sec) + 1e-3 * (double)(to.tv_nsec - from.tv_nsec);
    if (k < GOLDEN_STEPS || all[k] < least[row]) least[row] = all[k];
  }
  qsort(all, (size_t)steps, sizeof(double), by_size);
  qsort(least, GOLDEN_STEPS, sizeof(double), by_size);
  printf("all: median %.2f us, 99.99 %% %.2f us, worst %.2f us\n", all[steps / 2],
         all[steps - 1 - steps / 10000], all[steps - 1]);
  printf("undisturbed: median %.2f us, worst %.2f us, ratio %.2f\n", least[GOLDEN_STEPS / 2],
         least[GOLDEN_STEPS - 1], least[GOLDEN_STEPS - 1] / least[GOLDEN_STEPS / 2]);
  free(all);
  return 0;
}

/* Every call says that there is no filter of this robot, or none any more. */
static int all_say(int code) {
  orbident_detection detection;
  int bad = orbident_step(&ROBOT, memory, 5, sample) != code;
  bad |= orbident_detect(&ROBOT, memory, &detection) != code;
  bad |= orbident_open(&ROBOT, memory, 5) != code;
  bad |= orbident_get(&ROBOT, memory, ORBIDENT_BETA, beta, ROBOT_BETAS) != code;
  bad |= orbident_save(&ROBOT, memory, saved) != code;
  return bad | (orbident_restore(&ROBOT, other, ROBOT_MEMORY, memory) != code);
}

/* The checksum of a saved state, made anew: CRC-32, in two numbers behind all others, of which eight are. */
static void seal(void) {
  const unsigned char* const byte = (const unsigned char*)saved;
  uint32_t crc = ~0u;
  for (size_t i = 0; i < (ROBOT_STATE - 8) * sizeof *saved; ++i) {
    crc ^= byte[i];
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  saved[ROBOT_STATE - 8] = (orbident_real)(~crc >> 16);
  saved[ROBOT_STATE - 7] = (orbident_real)(~crc & 0xffff);
}

/* Whether a filter that was restored gives numbers, or a code below zero. */
static int gives_numbers(void) {
  orbident_detection found = {0, 0};
  for (int quantity = ORBIDENT_BETA; quantity <= ORBIDENT_DEVIATIONS; ++quantity) {
    const int code = orbident_get(&ROBOT, other, quantity, beta, ROBOT_BETAS);
    for (int i = 0; code >= 0 && i < ROBOT_BETAS; ++i)
      if (isnan(beta[i])) return 0;
  }
  orbident_step(&ROBOT, other, 7, sample);
  const int code = orbident_detect(&ROBOT, other, &found);
  return code < 0 || (!isnan(found.statistic) && isfinite(found.onset));
}

/* A saved state in which one number is another is refused, and the filter that is there stays. Where the
 * checksum is right, it is refused or gives numbers. All numbers before the factors, and some of those. */
static int spoilt_states(void) {
  begin(memory);
  orbident_step(&ROBOT, memory, 1, sample);
  if (orbident_save(&ROBOT, memory, saved) != ORBIDENT_DONE) return 1;
  const int kinds = (int)(sizeof SPOILED / sizeof *SPOILED);
  read_sample(1);
  for (long i = 0; i < ROBOT_STATE - 8; i += i < 64 ? 1 : 13)
    for (int kind = i < 64 ? 0 : (int)(i % kinds); kind < kinds; kind += i < 64 ? 1 : kinds) {
      const orbident_real was = saved[i], sum[2] = {saved[ROBOT_STATE - 8], saved[ROBOT_STATE - 7]};
      saved[i] = (orbident_real)SPOILED[kind];
      if (memcmp(saved + i, &was, sizeof was) == 0) continue;
      memset(other, 0, sizeof other);
      const int code = orbident_restore(&ROBOT, other, ROBOT_MEMORY, saved);
      if (code != (i == 0 ? ORBIDENT_NO_STATE : ORBIDENT_SPOILED) || other[0] != 0) return 1;
      seal();
      if (orbident_restore(&ROBOT, other, ROBOT_MEMORY, saved) >= 0 && !gives_numbers()) return 1;
      saved[i] = was;
      memcpy(saved + ROBOT_STATE - 8, sum, sizeof sum);
    }
  return orbident_restore(&ROBOT, other, ROBOT_MEMORY, saved) != ORBIDENT_DONE;
}

/* There is nothing to detect before a sample counts, nor twice of one. */
static int detects_once(void) {
  orbident_detection detection = {-1, -1};
  begin(memory);
  int bad = orbident_detect(&ROBOT, memory, &detection) != ORBIDENT_NO_SAMPLE;
  sample[0] = (orbident_real)NAN;
  bad |= orbident_step(&ROBOT, memory, 1, sample) != ORBIDENT_INCOMPLETE;
  bad |= orbident_detect(&ROBOT, memory, &detection) != ORBIDENT_NO_SAMPLE;
  read_sample(0);
  bad |= orbident_step(&ROBOT, memory, (orbident_real)INFINITY, sample) != ORBIDENT_INCOMPLETE;
  bad |= orbident_detect(&ROBOT, memory, &detection) != ORBIDENT_NO_SAMPLE;
  bad |= detection.statistic != -1 || detection.onset != -1;
  bad |= orbident_step(&ROBOT, memory, 1, sample) < 0;
  bad |= orbident_detect(&ROBOT, memory, &detection) != ORBIDENT_DONE;
  bad |= !(detection.statistic < 1) || detection.onset != 1;
  return bad | (orbident_detect(&ROBOT, memory, &detection) != ORBIDENT_NO_SAMPLE);
}

/* What is not finite is not taken for a momentum or a time. */
static int unknown_numbers(void) {
  const orbident_real h_cm[3] = {1, (orbident_real)NAN, 3};
  read_sample(0);
  int bad = orbident_init(&ROBOT, memory, ROBOT_MEMORY, sample, h_cm) != ORBIDENT_INCOMPLETE;
  bad |= all_say(ORBIDENT_NO_STATE);
  begin(memory);
  bad |= orbident_open(&ROBOT, memory, (orbident_real)INFINITY) != ORBIDENT_INCOMPLETE;
  return bad | (orbident_open(&ROBOT, memory, (orbident_real)NAN) != ORBIDENT_INCOMPLETE);
}

static int refusals(void) {
  orbident_detection detection;
  orbident_robot another = ROBOT;
  another.mark = ROBOT.mark == 1 ? 2 : 1;
  int bad = all_say(ORBIDENT_NO_STATE) | spoilt_states() | detects_once() | unknown_numbers();
  bad |= orbident_memory(&ROBOT) > ROBOT_MEMORY || orbident_state(&ROBOT) != ROBOT_STATE;
  read_sample(0);
  bad |= orbident_init(&ROBOT, memory, orbident_memory(&ROBOT) - 1, sample, 0) != ORBIDENT_NO_MEMORY;
  bad |= orbident_restore(&ROBOT, other, ROBOT_MEMORY / 2, memory) != ORBIDENT_NO_MEMORY;
  sample[0] = (orbident_real)NAN;
  bad |= orbident_init(&ROBOT, memory, ROBOT_MEMORY, sample, 0) != ORBIDENT_INCOMPLETE;
  sample[0] = (orbident_real)1e30;
  bad |= orbident_init(&ROBOT, memory, ROBOT_MEMORY, sample, 0) != ORBIDENT_ABSURD;
  bad |= all_say(ORBIDENT_NO_STATE);
  begin(memory);
  bad |= orbident_get(&ROBOT, memory, ORBIDENT_BETA, beta, ROBOT_BETAS - 1) != ORBIDENT_NO_SUCH;
  bad |= orbident_get(&ROBOT, memory, 99, beta, ROBOT_BETAS) != ORBIDENT_NO_SUCH;
  bad |= orbident_step(&another, memory, 0, sample) != ORBIDENT_NO_STATE;
  bad |= orbident_restore(&another, other, ROBOT_MEMORY, memory) != ORBIDENT_NO_STATE;
  bad |= orbident_step(&ROBOT, memory, 1, sample) < 0;
  bad |= orbident_step(&ROBOT, memory, 2, sample) != ORBIDENT_REPEATED;
  read_sample(1);
  bad |= orbident_step(&ROBOT, memory, 1, sample) != ORBIDENT_NOT_LATER;
  bad |= orbident_step(&ROBOT, memory, (orbident_real)2e9, sample) != ORBIDENT_ABSURD;
  bad |= orbident_step(&ROBOT, memory, (orbident_real)NAN, sample) != ORBIDENT_INCOMPLETE;
  /* A quaternion of zeros; then rates of which one number, or two, are the last ones. */
  const int w = 2 * ROBOT.joints;
  for (int i = 0; i < 4; ++i) sample[w + 3 + i] = 0;
  bad |= orbident_step(&ROBOT, memory, 2, sample) != ORBIDENT_ABSURD;
  for (int same = 1; same < 3; ++same) {
    orbident_real before[3];
    read_sample(same + 2);
    bad |= orbident_step(&ROBOT, memory, (orbident_real)(1 + 0.1 * same), sample) < 0;
    for (int i = 0; i < 3; ++i) before[i] = sample[w + i];
    read_sample(same + 3);
    for (int i = 0; i < same; ++i) sample[w + i] = before[i];
    bad |= orbident_step(&ROBOT, memory, (orbident_real)(1.05 + 0.1 * same), sample) < 0 && ROBOT.momenta > 1;
  }
  read_sample(1);
  /* The velocity, before w_smooth, h_given and what joints with torques have. */
  sample[ROBOT_MEASURED - ROBOT.driven_joints - 7] = (orbident_real)NAN;
  bad |= orbident_step(&ROBOT, memory, 2, sample) != ORBIDENT_NO_VELOCITY;
  bad |= orbident_detect(&ROBOT, memory, &detection) < 0;
  sample[0] = (orbident_real)INFINITY;
  bad |= orbident_step(&ROBOT, memory, 3, sample) != ORBIDENT_INCOMPLETE;
  bad |= orbident_open(&ROBOT, memory, 0) != ORBIDENT_DONE;
  read_sample(2);
  bad |= orbident_step(&ROBOT, memory, 1, sample) < 0; /* the clock was set back */
  const int rows = ROBOT.momenta + ROBOT.velocities;
  bad |= orbident_get(&ROBOT, memory, ORBIDENT_INNOVATION, beta, rows) != ORBIDENT_DONE;
  const int biases = ROBOT.momenta + (ROBOT.accelerometer ? ROBOT.velocities : 0);
  const int nuisances = rows + biases + 6 * ROBOT.driven_joints;
  bad |= orbident_get(&ROBOT, memory, ORBIDENT_NUISANCES, other, nuisances) != ORBIDENT_DONE;
  memory[0] = -memory[0];
  bad |= all_say(ORBIDENT_DIVERGED);
  return bad;
}

int main(int count, char** words) {
  const long number = count > 2 ? atol(words[2]) : 0;
  seed = 0x9e3779b97f4a7c15ull + (count > 3 ? strtoull(words[3], 0, 10) : 0);
  if (count > 1 && !strcmp(words[1], "fuzz")) return fuzz(number);
  if (count > 1 && !strcmp(words[1], "restore")) return restore(number);
  if (count > 1 && !strcmp(words[1], "times")) return times(number);
  /* With a known momentum too, and without a velocity. */
  const orbident_real h_cm[3] = {1, 2, 3};
  read_sample(0);
  sample[ROBOT_MEASURED - ROBOT.driven_joints - 9] = (orbident_real)NAN;
  if (orbident_init(&ROBOT, other, ROBOT_MEMORY, sample, h_cm) != ORBIDENT_DONE) return 1;
  return refusals();
}
