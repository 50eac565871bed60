// The free-flying base parameters sample by sample: an extended square-root information filter.
//
// The unknowns are [x | y] = [h_cm, v_cm, b_g, b_a | pi, phi], in which the conservation laws are
// linear: a triangular factor holds all that the samples said, whatever beta was believed to be
// meanwhile. What is known beforehand joins it by one Gauss-Newton step a sample:
//
//   beta = argmin |R y(beta) - z|^2 + |root (beta - beta_0)|^2
//
// A filter whose state is beta alone would linearise every sample about another beta and take the
// differences for information: from CAD values it gets lost. No smaller vector than y will do,
// which y(beta) spans. Once the estimate is good enough, [x | beta] takes over (hand_over.hpp).
//
// No function here allocates memory, throws, or keeps anything: state and room are the caller's.
#pragma once

#include "orbident/driven_joints.hpp"
#include "orbident/hand_over.hpp"
#include "orbident/sample_whitening.hpp"

namespace orbident {

// Whether a sample counts, or why not.
enum class Counts { yes, incomplete, absurd, not_later, repeated };

// What one sample said about the estimate before it.
struct Innovation {
  const Real* white;  // `stride` entries apart: independent, unit variance while nothing changes
  int stride;
  Real nis;  // |white|^2: chi-square with dof degrees of freedom
  int dof;   // 0 where the sample does not count
  Counts counts;
};

// In the plane momentum has its last component alone.
inline Vector momentum_in(const FilterModel& model, const Real* x) {
  return model.laws.axes.momenta == 1 ? Vector(0, 0, x[0]) : Vector(x[0], x[1], x[2]);
}

constexpr Real LARGEST = 1e6;          // SI: no angle, rate or speed of a spacecraft is beyond it
constexpr Real LONGEST = 1e9;          // s: nor is the time between two samples, which is 30 years
constexpr Real SHORTEST = Real(1e-6);  // of a quaternion's squared norm; any norm will do but none

// A sample counts if it is complete but for the velocity, possible, later than the last one, and of
// a live gyro: one whose rate is the last one's to the last digit is dead, or its row was written
// twice.
inline Counts counts(const FilterModel& model, const FilterState& state, Real t,
                     const Measurement& at) {
  const Robot& robot = model.laws.robot;
  const int needed = 2 * robot.tree.joints + 7 + robot.wheels;
  bool all = std::isfinite(t), possible = true;
  const auto look = [&](const Real* part, int size) {
    for (int i = 0; i < size; ++i) {
      all = all && std::isfinite(part[i]);
      possible = possible && std::abs(part[i]) < LARGEST;
    }
  };
  look(at.q, needed);
  look(at.w_smooth, 3);
  look(at.h_given, 3);
  if (!all) return Counts::incomplete;
  const Vector v_S(at.v_S[0], at.v_S[1], at.v_S[2]);
  if (v_S.allFinite()) look(at.v_S, 3);
  Real norm = 0;
  for (int i = 0; i < 4; ++i) norm += at.x_WB[i] * at.x_WB[i];
  if (!possible || norm < SHORTEST || t - *state.t > LONGEST) return Counts::absurd;
  if (t <= *state.t) return Counts::not_later;
  const bool same = at.w[0] == state.w[0] && at.w[1] == state.w[1] && at.w[2] == state.w[2];
  return same ? Counts::repeated : Counts::yes;
}

// What belongs to the rows of a sample that are not whitened yet.
struct SampleEquations {
  EquationNoise noise;
  Matrix R_WB;
  Vector h;  // inertial axes
  bool moving;
};

// Writes the rows [x | y] of one sample, or [x | beta], linearised about the estimate.
inline SampleEquations equations_of(const FilterModel& model, const FilterState& state,
                                    const Measurement& at, Real* rows, FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const int stride = size.row_stride();
  SampleEquations found;
  found.h = momentum_in(model, state.x) + given_momentum(at);
  found.R_WB = quaternion_matrix<Real>(Quaternion<Real>(at.x_WB));
  found.moving = Vector(at.v_S[0], at.v_S[1], at.v_S[2]).allFinite();
  found.noise = conservation_equations(model.laws, state.beta, found.h, at, found.R_WB,
                                       room.equations, rows, stride);
  driven_equations(model.laws, at, room.equations, rows + size.rows * stride, stride);
  if (held_in_beta(state))
    rows_of_beta(model, state, rows + size.nuisances, stride, size.all_rows(), size.beta_stride(),
                 room);
  return found;
}

// Moves the nuisances on to the time t of a sample that counts, and takes what its rows say of
// them; what is left of these, whitened, is about the parameters alone.
inline void take_nuisances_in(const FilterModel& model, FilterState& state, Real t,
                              const Measurement& at, const SampleEquations& sample, Real* rows,
                              FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const ConservedAxes& axes = model.laws.axes;
  const int n = size.nuisances, y = held_in_beta(state) ? size.betas() : size.parameters;
  const int stride = size.row_stride(), top_stride = size.top_stride();
  const Real dt = std::isnan(*state.t) ? Real(0) : t - *state.t;
  const Eigen::Map<Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>> R_before(state.R_WB);
  const Matrix integral = dt / 2 * (R_before + sample.R_WB);
  momenta_walk(model, state, at, dt, n + y + 1, room.walk);
  const Matrix of_gyro = predict_nuisances(model.laws, state.top, top_stride, n + y + 1, integral,
                                           sample.h, dt, room.walk, room.kick, room.covariance);
  Real* const driven = rows + size.rows * stride;
  follow_momenta(model, state, at, dt, n + y + 1, driven + size.driven * stride, stride);
  whiten_law(sample.noise.momentum, axes.momentum, axes.momenta, of_gyro, axes.momenta, state.top,
             top_stride, rows, stride, n + y + 1);
  if (sample.moving)
    whiten_law(sample.noise.velocity, axes.velocity, axes.velocities, of_gyro, axes.momenta,
               state.top, top_stride, rows + axes.momenta * stride, stride, n + y + 1);
  fold(state.top, top_stride, rows, stride, size.rows, padded(n + y + 1), n);
  fold(state.top, top_stride, driven, stride, size.driven, padded(n + y + 1), n);
  *state.t = t;
  for (int i = 0; i < 3; ++i) state.w[i] = at.w[i];
  for (int i = 0; i < 9; ++i) state.R_WB[i] = sample.R_WB(i / 3, i % 3);
}

// Takes the equations of one sample in, linearised about the estimate, which stays.
inline Innovation take_in(const FilterModel& model, FilterState& state, Real t, const Real* packed,
                          FilterRoom& room) {
  const Measurement at = measurement_at(model.laws.robot, packed);
  const FilterSizes size = model.sizes();
  const bool reduced = held_in_beta(state);
  const int n = size.nuisances, y = reduced ? size.betas() : size.parameters;
  const int stride = size.row_stride();
  const Counts reason = counts(model, state, t, at);
  if (reason != Counts::yes) {
    for (int i = 0; i < size.rows; ++i) room.rows[i * stride + n + y] = 0.0;
    return {room.rows + n + y, stride, 0.0, 0, reason};
  }
  const SampleEquations sample = equations_of(model, state, at, room.rows, room);
  take_nuisances_in(model, state, t, at, sample, room.rows, room);
  const int R_stride = reduced ? size.beta_stride() : size.R_stride();
  Real *const R = reduced ? state.root : state.R, *const driven = room.rows + size.rows * stride;
  // Torques come after the laws, whose innovation tells of changes alone.
  fold(R, R_stride, room.rows + n, stride, size.rows, R_stride, y);
  fold(R, R_stride, driven + n, stride, size.driven, R_stride, y);
  Innovation innovation{room.rows + n + y, stride, 0.0, size.rows, reason};
  for (int i = 0; i < size.rows; ++i) {
    const Real white = innovation.white[i * stride];
    innovation.nis += white * white;
  }
  if (!sample.moving) innovation.dof = model.laws.axes.momenta;
  return innovation;
}

// Of M_0, to which M is held where nothing can tell the scale.
constexpr Real HELD = Real(1e-3);

// One Gauss-Newton step from the last beta: [R J | z + R (J beta - y)] and the prior, triangular.
//
// Without a wheel M is held at M_0. The lighter a robot, the better it fits equations without a
// known term, and the less their noise is, which is D's and U's: the estimate would shrink to
// nothing, ever faster.
inline void relinearise(const FilterModel& model, FilterState& state, FilterRoom& room) {
  const ParametersOfBeta& sets = model.sets;
  const FilterSizes size = model.sizes();
  const int k = size.betas(), iotas = size.iotas, shown = size.shown, y = size.parameters;
  const int stride = size.beta_stride(), R_stride = size.R_stride();
  const int block_stride = padded(shown + 1);
  for (int i = 0; i < sets.sigmas; ++i) room.phi[i] = state.beta[1 + i] / state.beta[0];
  for (long i = 0; i < static_cast<long>(k) * stride; ++i) state.root[i] = 0.0;
  // Rows below those of iota wait in a block until it is full.
  int waiting = 0;
  const auto fold_waiting = [&] {
    fold(state.root + iotas * stride + iotas, stride, room.block, block_stride, waiting,
         block_stride, shown);
    waiting = 0;
  };
  for (int first = 0; first < y; first += TILE) {
    const int rows = y - first < TILE ? y - first : TILE;
    shown_columns(sets, state.R + static_cast<long>(first) * R_stride, R_stride, rows, first,
                  room.phi, state.beta[0], room.transposed, room.shown);
    for (int r = 0; r < rows; ++r) {
      const int row = first + r;
      Real* into = state.root + row * stride + iotas;
      if (row < iotas) {
        for (int c = row; c < iotas; ++c) into[c - iotas] = state.R[row * R_stride + c];
      } else {
        into = room.block + waiting++ * block_stride;
        for (int c = shown + 1; c < block_stride; ++c) into[c] = 0.0;
      }
      for (int c = 0; c <= shown; ++c) into[c] = room.shown[c * TILE + r];
      if (waiting == BLOCK) fold_waiting();
    }
  }
  fold_waiting();
  for (int first = 0; first < k; first += BLOCK) {
    const int left = k - first, count = left < BLOCK ? left : BLOCK;
    for (int i = 0; i < count * stride; ++i) room.block[i] = state.prior[first * stride + i];
    fold(state.root + first * stride + first, stride, room.block + first, stride, count,
         stride - first, left);
  }
  if (model.laws.robot.wheels > 0) return;
  // (M - M_0) / (HELD M_0)
  solve_triangle(state.prior, stride, k, room.beta);
  for (int i = 0; i < stride; ++i) room.block[i] = 0.0;
  room.block[iotas] = 1 / (HELD * room.beta[iotas]);
  room.block[k] = 1 / HELD;
  fold(state.root + iotas * stride + iotas, stride, room.block + iotas, stride, 1, stride - iotas,
       shown);
}

// The new estimate of beta and of the nuisances.
inline void estimate(const FilterModel& model, FilterState& state, FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const bool reduced = held_in_beta(state);
  if (!reduced) relinearise(model, state, room);
  const int k = size.betas(), iotas = size.iotas, shown = size.shown;
  Real *const ordered = room.beta, *const beta = room.beta + k;
  solve_triangle(state.root, size.beta_stride(), k, ordered);
  for (int i = 0; i < k; ++i) beta[i] = ordered[i < shown ? iotas + i : i - shown];
  if (!reduced) linearised(model.sets, state.beta, beta, room.y);
  const Real* const known = reduced ? ordered : room.y;

  // x of N x + Y y = z.
  const int n = size.nuisances, y = reduced ? k : size.parameters, top = size.top_stride();
  for (int i = n - 1; i >= 0; --i) {
    const Real* const row = state.top + i * top;
    const Real left = row[n + y] - dot(row + n, known, y);
    state.x[i] = (left - dot(row + i + 1, state.x + i + 1, n - i - 1)) / row[i];
  }
  for (int i = 0; i < k; ++i) state.beta[i] = beta[i];
  if (!reduced) hand_over_if_linear(model, state, room);
}

// One sample: prediction of the nuisances, its equations, the new estimate.
inline Innovation step(const FilterModel& model, FilterState& state, Real t, const Real* packed,
                       FilterRoom& room) {
  const Innovation innovation = take_in(model, state, t, packed, room);
  if (innovation.dof > 0) estimate(model, state, room);
  return innovation;
}

}  // namespace orbident
