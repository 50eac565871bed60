// The interface of flight.h, in the code that Python runs. One source file of a program includes
// it.
//
// Beside the filter's own step it only looks at what comes in and what comes out: a sample that
// does not count says why, and numbers that ran out of range stop the filter instead of being
// handed on.
#pragma once

#include "orbident/flight_memory.hpp"

namespace orbident::flight {

// Stops a filter whose numbers ran out of range.
inline int checked(const Layout& at, bool sound, int code) {
  if (sound) return code;
  *at.mark = -std::abs(*at.mark);
  return ORBIDENT_DIVERGED;
}

// Whether all that is carried can be a filter's; the detector has not seen the last sample, or has.
inline bool is_sound(const Layout& at) {
  const bool seen = std::isnan(*at.t);
  return (seen || *at.t == *at.filter.t) && is_finite(at.white, at.size.rows) &&
         orbident::is_sound(at.filter, at.size) && orbident::is_sound(at.watch, *at.filter.t);
}

inline int status(const orbident_robot& robot, Real mark) {
  if (mark == static_cast<Real>(robot.mark)) return ORBIDENT_DONE;
  return mark == -static_cast<Real>(robot.mark) ? ORBIDENT_DIVERGED : ORBIDENT_NO_STATE;
}

inline int code_of(Counts counts) {
  switch (counts) {
    case Counts::yes:
      return ORBIDENT_DONE;
    case Counts::incomplete:
      return ORBIDENT_INCOMPLETE;
    case Counts::absurd:
      return ORBIDENT_ABSURD;
    case Counts::not_later:
      return ORBIDENT_NOT_LATER;
    case Counts::repeated:
      break;
  }
  return ORBIDENT_REPEATED;
}

}  // namespace orbident::flight

extern "C" {

long orbident_memory(const orbident_robot* robot) {
  return orbident::flight::layout(*robot, nullptr).all;
}

long orbident_state(const orbident_robot* robot) {
  return orbident::flight::layout(*robot, nullptr).carried;
}

int orbident_init(const orbident_robot* robot, orbident_real* memory, long numbers,
                  const orbident_real* sample, const orbident_real* h_cm) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  if (numbers < at.all) return ORBIDENT_NO_MEMORY;
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel, at.driven);
  for (long i = 0; i < at.carried; ++i) memory[i] = 0;
  if (h_cm && !is_finite(h_cm, 3)) return ORBIDENT_INCOMPLETE;
  *at.filter.t = NOT_A_NUMBER;
  for (int i = 0; i < 3; ++i) at.filter.w[i] = NOT_A_NUMBER;
  const Counts first = counts(model, at.filter, 0, measurement_at(model.laws.robot, sample));
  if (first != Counts::yes) return flight::code_of(first);
  flight::prepare(*robot, memory, at);
  start(model, robot->beta, robot->root, sample, h_cm, at.filter, at.room);
  watch_nothing(at.watch);
  *at.t = NOT_A_NUMBER;
  *at.mark = static_cast<Real>(robot->mark);
  return flight::checked(at, is_estimate(at.filter, at.size), ORBIDENT_DONE);
}

int orbident_save(const orbident_robot* robot, orbident_real* memory, orbident_real* saved) {
  using namespace orbident;
  const flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  if (!flight::is_sound(at)) return flight::checked(at, false, ORBIDENT_DONE);
  checksum(memory, at.summed, at.checksum);
  for (long i = 0; i < at.carried; ++i) saved[i] = memory[i];
  return ORBIDENT_DONE;
}

int orbident_restore(const orbident_robot* robot, orbident_real* memory, long numbers,
                     const orbident_real* saved) {
  using namespace orbident;
  const flight::Layout at = flight::layout(*robot, memory);
  if (numbers < at.all) return ORBIDENT_NO_MEMORY;
  const int status = flight::status(*robot, saved[0]);
  if (status != ORBIDENT_DONE) return status;
  // A layout is of an array that is written to; this one is only read.
  const flight::Layout from = flight::layout(*robot, const_cast<Real*>(saved));
  Real halves[2];
  checksum(saved, from.summed, halves);
  const bool whole = halves[0] == from.checksum[0] && halves[1] == from.checksum[1];
  if (!whole || !flight::is_sound(from)) return ORBIDENT_SPOILED;
  for (long i = 0; i < at.carried; ++i) memory[i] = saved[i];
  flight::prepare(*robot, memory, at);
  return ORBIDENT_DONE;
}

int orbident_step(const orbident_robot* robot, orbident_real* memory, orbident_real t,
                  const orbident_real* sample) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel, at.driven);
  const int rows = at.size.rows;
  const Innovation innovation = step(model, at.filter, t, sample, at.room);
  for (int i = 0; i < rows; ++i) at.white[i] = innovation.white[i * innovation.stride];
  *at.t = NOT_A_NUMBER;
  if (innovation.counts != Counts::yes) return flight::code_of(innovation.counts);
  *at.t = t;
  const int code = innovation.dof < rows ? ORBIDENT_NO_VELOCITY : ORBIDENT_DONE;
  return flight::checked(at, is_finite(at.white, rows) && is_estimate(at.filter, at.size), code);
}

int orbident_detect(const orbident_robot* robot, orbident_real* memory, orbident_detection* out) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  if (std::isnan(*at.t)) return ORBIDENT_NO_SAMPLE;
  const Likelihood most = watch_one(at.watch, *at.t, at.white, 1);
  *at.t = NOT_A_NUMBER;
  out->statistic = most.g / robot->threshold;
  out->onset = most.onset;
  return most.g > robot->threshold ? ORBIDENT_CHANGED : ORBIDENT_DONE;
}

int orbident_open(const orbident_robot* robot, orbident_real* memory, orbident_real t) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel, at.driven);
  if (!std::isfinite(t)) return ORBIDENT_INCOMPLETE;
  open_up(model, at.filter, t, robot->opening, at.opening, at.room);
  watch_nothing(at.watch);
  *at.t = NOT_A_NUMBER;
  return flight::checked(at, is_estimate(at.filter, at.size), ORBIDENT_DONE);
}

int orbident_get(const orbident_robot* robot, orbident_real* memory, int quantity,
                 orbident_real* out, int size_of_out) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel, at.driven);
  const FilterSizes& size = at.size;
  const Real* from = nullptr;
  int count = -1;
  switch (quantity) {
    case ORBIDENT_BETA:
      from = at.filter.beta, count = size.betas();
      break;
    case ORBIDENT_DEVIATIONS:
      count = size.betas();
      break;
    case ORBIDENT_NUISANCES:
      from = at.filter.x, count = size.nuisances;
      break;
    case ORBIDENT_INNOVATION:
      from = at.white, count = size.rows;
      break;
    default:
      break;
  }
  if (size_of_out != count) return ORBIDENT_NO_SUCH;
  if (quantity == ORBIDENT_DEVIATIONS) deviations(model, at.filter, at.room, out);
  for (int i = 0; from && i < count; ++i) out[i] = from[i];
  const bool of_beta = quantity == ORBIDENT_BETA || quantity == ORBIDENT_DEVIATIONS;
  const bool scale = !of_beta || scaled(model, at.filter, robot->beta[0]);
  return flight::checked(at, is_finite(out, count), scale ? ORBIDENT_DONE : ORBIDENT_NO_SCALE);
}

}  // extern "C"
