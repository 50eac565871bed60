// The interface of flight.h, in the code that Python runs. To be included in one source file of a program.
//
// Beside the filter's own step it only looks at what comes in and what comes out: a sample that does not
// count says why, and numbers that ran out of range stop the filter instead of being handed on.
#pragma once

#include "orbident/flight_memory.hpp"

namespace orbident::flight {

// Whether a factor's information is positive definite: its diagonal has no zero, and nothing overflowed.
inline bool is_definite(const Real* factor, int stride, int rows) {
  for (int i = 0; i < rows; ++i) {
    const Real pivot = std::abs(factor[static_cast<long>(i) * stride + i]);
    if (!(pivot > 0 && std::isfinite(pivot))) return false;
  }
  return true;
}

inline bool is_finite(const Real* numbers, int count) {
  for (int i = 0; i < count; ++i)
    if (!std::isfinite(numbers[i])) return false;
  return true;
}

inline bool is_sound(const FilterState& state, const FilterSizes& size) {
  return is_finite(state.beta, size.betas()) && is_finite(state.x, size.nuisances) &&
         is_definite(state.root, size.beta_stride(), size.betas()) &&
         is_definite(state.top, size.top_stride(), size.nuisances);
}

// Stops a filter whose numbers are not sound.
inline int checked(const Layout& at, const FilterSizes& size, int code) {
  if (is_sound(at.filter, size)) return code;
  *at.mark = -std::abs(*at.mark);
  return ORBIDENT_DIVERGED;
}

inline int status(const orbident_robot& robot, Real mark) {
  if (mark == static_cast<Real>(robot.mark)) return ORBIDENT_DONE;
  return mark == -static_cast<Real>(robot.mark) ? ORBIDENT_DIVERGED : ORBIDENT_NO_STATE;
}

inline int code_of(Counts counts) {
  switch (counts) {
    case Counts::yes: return ORBIDENT_DONE;
    case Counts::incomplete: return ORBIDENT_INCOMPLETE;
    case Counts::absurd: return ORBIDENT_ABSURD;
    case Counts::not_later: return ORBIDENT_NOT_LATER;
    case Counts::repeated: break;
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
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel);
  const FilterSizes size = model.sizes();
  *at.mark = 0;
  *at.filter.t = NOT_A_NUMBER;
  for (int i = 0; i < 3; ++i) at.filter.w[i] = NOT_A_NUMBER;
  const Counts first = counts(model, at.filter, 0, measurement_at(model.laws.robot, sample));
  if (first != Counts::yes) return flight::code_of(first);
  flight::prepare(*robot, memory, at);
  start(model, robot->beta, robot->root, sample, h_cm, at.filter, at.room);
  watch_nothing(at.watch);
  *at.t = NOT_A_NUMBER;
  for (int i = 0; i < size.rows; ++i) at.white[i] = 0;
  *at.mark = static_cast<Real>(robot->mark);
  return flight::checked(at, size, ORBIDENT_DONE);
}

int orbident_restore(const orbident_robot* robot, orbident_real* memory, long numbers,
                     const orbident_real* saved) {
  using namespace orbident;
  const flight::Layout at = flight::layout(*robot, memory);
  if (numbers < at.all) return ORBIDENT_NO_MEMORY;
  const int status = flight::status(*robot, saved[0]);
  if (status != ORBIDENT_DONE) return status;
  for (long i = 0; i < at.carried; ++i) memory[i] = saved[i];
  flight::prepare(*robot, memory, at);
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel);
  return flight::checked(at, model.sizes(), ORBIDENT_DONE);
}

int orbident_step(const orbident_robot* robot, orbident_real* memory, orbident_real t,
                  const orbident_real* sample) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel);
  const FilterSizes size = model.sizes();
  const Innovation innovation = step(model, at.filter, t, sample, at.room);
  *at.t = t;
  for (int i = 0; i < size.rows; ++i) at.white[i] = innovation.white[i * innovation.stride];
  if (innovation.counts != Counts::yes) return flight::code_of(innovation.counts);
  const int code = innovation.dof < size.rows ? ORBIDENT_NO_VELOCITY : ORBIDENT_DONE;
  return flight::checked(at, size, code);
}

int orbident_detect(const orbident_robot* robot, orbident_real* memory, orbident_detection* out) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  const Likelihood most = watch_one(at.watch, *at.t, at.white, 1);
  out->statistic = most.g / robot->threshold;
  out->onset = most.onset;
  return most.g > robot->threshold ? ORBIDENT_CHANGED : ORBIDENT_DONE;
}

int orbident_open(const orbident_robot* robot, orbident_real* memory, orbident_real t) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel);
  open_up(model, at.filter, t, robot->opening, at.opening, at.room);
  watch_nothing(at.watch);
  return flight::checked(at, model.sizes(), ORBIDENT_DONE);
}

int orbident_get(const orbident_robot* robot, orbident_real* memory, int quantity,
                 orbident_real* out, int size_of_out) {
  using namespace orbident;
  flight::Layout at = flight::layout(*robot, memory);
  const int status = flight::status(*robot, *at.mark);
  if (status != ORBIDENT_DONE) return status;
  const FilterModel model = flight::model_of(*robot, at.joint, at.wheel);
  const FilterSizes size = model.sizes();
  const Real* from = nullptr;
  int count = -1;
  switch (quantity) {
    case ORBIDENT_BETA: from = at.filter.beta, count = size.betas(); break;
    case ORBIDENT_DEVIATIONS: count = size.betas(); break;
    case ORBIDENT_NUISANCES: from = at.filter.x, count = size.nuisances; break;
    case ORBIDENT_INNOVATION: from = at.white, count = size.rows; break;
    default: break;
  }
  if (size_of_out != count) return ORBIDENT_NO_SUCH;
  if (quantity == ORBIDENT_DEVIATIONS) deviations(model, at.filter, at.room, out);
  for (int i = 0; from && i < count; ++i) out[i] = from[i];
  const bool of_beta = quantity == ORBIDENT_BETA || quantity == ORBIDENT_DEVIATIONS;
  return of_beta && !scaled(model, at.filter, robot->beta[0]) ? ORBIDENT_NO_SCALE : ORBIDENT_DONE;
}

}  // extern "C"
