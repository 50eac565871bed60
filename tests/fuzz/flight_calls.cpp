// Calls of the flight filter, in any order and with any numbers, as libFuzzer draws them.
//
// Saved states have numbers changed in every field, and their checksum is made anew, so that what
// comes after the checksum is reached. Whatever came before:
//
//   no call gives a number that is NaN without a code below zero;
//   what orbident_save gives is accepted by orbident_restore, and goes on with the same bits;
//   what orbident_restore refuses leaves the filter as it was.
//
// test_flight_calls.py builds it with the tables of a robot.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "flight.cpp"  // the filter, as it is exported
#include "golden.h"

namespace {

using Real = orbident_real;

constexpr long MEMORY = ROBOT_MEMORY, STATE = ROBOT_STATE, MEASURED = ROBOT_MEASURED;
constexpr int BETAS = ROBOT_BETAS, ROWS = ROBOT.momenta + ROBOT.velocities,
              NUISANCES = ROWS + ROBOT.momenta + (ROBOT.accelerometer ? ROBOT.velocities : 0) +
                          6 * ROBOT.driven_joints;

Real memory[MEMORY], other[MEMORY], saved[STATE], sample[MEASURED], out[BETAS + NUISANCES + ROWS];
Real t;
long row, steps;

void demand(bool held, const char* what) {
  if (held) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

// The bytes that are left of an input; zeros after them.
struct Bytes {
  const std::uint8_t* next;
  std::size_t left;

  unsigned one() { return left ? --left, *next++ : 0u; }
  long below(long n) {
    long number = 0;
    for (long most = 1; most < n; most *= 256) number = 256 * number + one();
    return number % n;
  }
  Real real() {
    using Limits = std::numeric_limits<Real>;
    const Real odd[] = {Limits::quiet_NaN(),
                        Limits::infinity(),
                        -Limits::infinity(),
                        Limits::max(),
                        -Limits::max(),
                        Limits::min(),
                        Limits::denorm_min(),
                        0,
                        -1,
                        1,
                        Real(0.5),
                        31,
                        32,
                        33,
                        Real(9.99e5),
                        Real(1e6),
                        Real(1e9),
                        Real(2147483647.0),
                        Real(-2147483648.0)};
    constexpr unsigned KINDS = sizeof odd / sizeof *odd;
    const unsigned kind = one() % (KINDS + 9);
    if (kind < KINDS) return odd[kind];
    Real number = 0;
    if (kind == KINDS) {  // any bits
      for (std::size_t i = 0; i < sizeof number; ++i)
        reinterpret_cast<unsigned char*>(&number)[i] = static_cast<unsigned char>(one());
      return number;
    }
    return static_cast<Real>(static_cast<std::int8_t>(one())) / 16;
  }
};

bool numbers(const Real* from, int count) {
  for (int i = 0; i < count; ++i)
    if (std::isnan(from[i])) return false;
  return true;
}

void look(Real* at) {
  const int size[] = {BETAS, BETAS, NUISANCES, ROWS};
  for (int quantity = 0; quantity < 4; ++quantity) {
    const int code = orbident_get(&ROBOT, at, quantity, out, size[quantity]);
    demand(code < 0 || numbers(out, size[quantity]), "orbident_get gave NaN");
  }
  demand(orbident_get(&ROBOT, at, 0, out, BETAS + 1) < 0, "a wrong size was taken");
}

void begin(Bytes& bytes) {
  const Real h_cm[3] = {bytes.real(), bytes.real(), bytes.real()};
  const bool known = bytes.one() % 4 == 0;
  orbident_init(&ROBOT, memory, bytes.one() % 16 ? MEMORY : MEMORY - 1, sample,
                known ? h_cm : nullptr);
}

// The recording goes on, with some numbers changed.
int step(Bytes& bytes) {
  row = (row + 1) % GOLDEN_STEPS;
  for (long i = 0; i < MEASURED; ++i)
    sample[i] = static_cast<Real>(GOLDEN_SAMPLE[row * MEASURED + i]);
  for (unsigned changed = bytes.one() % 8; changed > 4; --changed)
    sample[bytes.below(MEASURED)] = bytes.real();
  t += bytes.one() % 16 ? Real(0.1) : bytes.real();
  ++steps;
  return orbident_step(&ROBOT, memory, t, sample);
}

void detect() {
  orbident_detection found{};
  const int code = orbident_detect(&ROBOT, memory, &found);
  demand(code < 0 || (!std::isnan(found.statistic) && std::isfinite(found.onset)),
         "orbident_detect gave NaN");
  demand(orbident_detect(&ROBOT, memory, &found) < 0, "a sample was detected twice");
  if (code == ORBIDENT_CHANGED) orbident_open(&ROBOT, memory, t);
}

// A copy goes on as the filter does.
void save() {
  if (orbident_save(&ROBOT, memory, saved) < 0) return;
  demand(orbident_restore(&ROBOT, other, MEMORY, saved) == ORBIDENT_DONE,
         "a saved state was refused");
  const int code = orbident_step(&ROBOT, memory, t + 1, sample);
  demand(orbident_step(&ROBOT, other, t + 1, sample) == code, "a copy gave another code");
  demand(std::memcmp(memory, other, sizeof(Real) * (STATE - 2 * orbident::LANES)) == 0,
         "a copy gave other numbers");
}

void spoil(Bytes& bytes) {
  if (orbident_save(&ROBOT, memory, saved) < 0) return;
  const orbident::flight::Layout at = orbident::flight::layout(ROBOT, saved);
  const orbident::FilterState& filter = at.filter;
  Real* const field[] = {at.mark,     at.t,          at.white,     filter.t,      filter.w,
                         filter.R_WB, filter.linear, filter.top,   filter.R,      filter.beta,
                         filter.x,    filter.root,   filter.prior, at.watch.sums, at.watch.times,
                         at.checksum, saved + STATE};
  constexpr long FIELDS = sizeof field / sizeof *field - 1;
  for (unsigned changed = 1 + bytes.one() % 3; changed > 0; --changed) {
    Real* const* const of = field + bytes.below(FIELDS);
    of[0][bytes.below(of[1] - of[0])] = bytes.real();
  }
  if (bytes.one() % 8) orbident::checksum(saved, at.summed, at.checksum);
  std::memcpy(other, memory, sizeof memory);
  const int code = orbident_restore(&ROBOT, memory, MEMORY, saved);
  demand(code >= 0 || std::memcmp(memory, other, sizeof memory) == 0,
         "a refused state changed the filter");
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  return std::atexit([] { std::printf("%ld steps\n", steps); });
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes{data, size};
  std::memset(memory, 0, sizeof memory);
  t = 0;
  row = -1;
  for (long i = 0; i < MEASURED; ++i) sample[i] = static_cast<Real>(GOLDEN_SAMPLE[i]);
  if (bytes.one() % 16) orbident_init(&ROBOT, memory, MEMORY, sample, nullptr);
  while (bytes.left) {
    switch (bytes.one() % 12) {
      case 0:
        begin(bytes);
        break;
      case 1:
        t += bytes.real(), orbident_open(&ROBOT, memory, t);
        break;
      case 2:
        save();
        break;
      case 3:
      case 4:
        spoil(bytes);
        break;
      case 5:
        detect();
        break;
      default:
        for (unsigned more = 1 + bytes.one() % 8; more > 0; --more) step(bytes), detect();
    }
    look(memory);
  }
  return 0;
}
