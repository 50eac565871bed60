// What the information filter carries from sample to sample, and how it begins.
//
// State and room are the caller's memory: `state_in` and `room_in` lay them out in one block of
// numbers, or count how many they need (a Memory that begins nowhere), at compile time too.
#pragma once

#include "orbident/nuisance_prediction.hpp"
#include "orbident/parameters_of_beta.hpp"

namespace orbident {

constexpr Real MOMENTUM_UNKNOWN = 10.0;      // so many times what beta and the first sample say
constexpr Real FASTEST = 10.0;               // m/s: no point moves faster relative to the CM
constexpr Real EXACT_MOMENTUM = Real(1e-6);  // N m s: error of a momentum that is known

struct FilterSizes {
  int nuisances;   // x
  int parameters;  // y
  int shown;       // M and sigma
  int iotas;
  int rows;    // of a sample
  int driven;  // joints with as many rows more, and as many again of what changes their momenta
  constexpr int all_rows() const { return rows + 2 * driven; }
  constexpr int betas() const { return shown + iotas; }
  constexpr int top_stride() const { return padded(nuisances + parameters + 1); }
  constexpr int R_stride() const { return padded(parameters + 1); }
  // Rows of a sample begin so far behind a multiple of LANES that y begins at one.
  constexpr int row_start() const { return padded(nuisances) - nuisances; }
  constexpr int row_stride() const { return padded(nuisances) + padded(parameters + 1) + LANES; }
  // Of [iota, M, sigma | right-hand side]; the part from M on is padded too.
  constexpr int beta_stride() const { return padded(iotas + padded(shown + 1)); }
};

struct FilterModel {
  ConservationModel laws;
  ParametersOfBeta sets;
  constexpr FilterSizes sizes() const {
    return {laws.nuisances(), sets.size(),     sets.shown(),
            sets.iotas,       laws.axes.all(), laws.driven.count};
  }
};

// Hands out parts of the caller's memory, or only counts them. Each begins at a multiple of LANES.
struct Memory {
  Real* first;
  long used = 0;
  constexpr Real* take(int rows, int columns = 1) {
    Real* const part = first ? first + used : nullptr;
    used += padded(rows * columns);
    return part;
  }
};

struct FilterState {
  Real* t;        // of the last sample, s; NaN before the first
  Real* w;        // the gyro's last sample, rad/s
  Real* impulse;  // of the last sample, of driven joints, N m s; NaN where none was
  Real* R_WB;     // 3 x 3, row-major
  Real* linear;   // points in a row at which y(beta) was linear (hand_over.hpp)
  Real* q;        // the last position of driven joints,
  Real* qd;       // and rate
  Real* slope;    // rows [x | y | rhs] of how their energy changed with their positions then
  Real* top;      // [N | Y | z], N x + Y y = z, N upper triangular
  Real* R;        // [R | z], R y = z, upper triangular
  Real* beta;     // the estimate [M, sigma, iota]
  Real* x;        // the nuisances
  Real* root;     // [iota, M, sigma | z], upper triangular: root^T root is beta's information
  Real* prior;    // the same of what was known beforehand
};

constexpr FilterState state_in(const FilterSizes& size, Memory& memory) {
  FilterState state{};
  state.t = memory.take(1);
  state.w = memory.take(3);
  state.impulse = memory.take(size.driven);
  state.R_WB = memory.take(9);
  state.linear = memory.take(1);
  state.q = memory.take(size.driven);
  state.qd = memory.take(size.driven);
  state.slope = memory.take(size.driven, size.top_stride());
  state.top = memory.take(size.nuisances, size.top_stride());
  state.R = memory.take(size.parameters, size.R_stride());
  state.beta = memory.take(size.betas());
  state.x = memory.take(size.nuisances);
  state.root = memory.take(size.betas(), size.beta_stride());
  state.prior = memory.take(size.betas(), size.beta_stride());
  return state;
}

// Room for one step.
struct FilterRoom {
  EquationMemory equations;
  Real* rows;        // of a sample
  Real* walk;        // of driven joints: deviation of what their momenta gain, N m s
  Real* kick;        // x and momenta by x
  Real* covariance;  // x by x
  Real* x;
  Real* y;
  Real* phi;
  Real* beta;        // twice, and in both orders
  Real* transposed;  // TILE rows of R, or of root
  Real* shown;       // TILE rows of R J
  Real* block;       // BLOCK rows of [iota, M, sigma | z]
};

constexpr FilterRoom room_in(const FilterModel& model, const Bodies<Real>& bodies, Memory& memory) {
  const FilterSizes size = model.sizes();
  const int thetas = PER_BODY * model.laws.robot.tree.bodies();
  FilterRoom room{};
  room.equations.bodies = bodies;
  room.equations.theta = memory.take(thetas);
  room.equations.columns = memory.take(9, thetas);
  room.equations.sigma = memory.take(3, model.laws.sets.phis());
  room.equations.Y = memory.take(3, model.laws.sets.pis());
  room.equations.W = memory.take(3, model.laws.sets.phis());
  room.equations.load = memory.take(6, size.driven ? model.laws.robot.tree.bodies() : 0);
  room.equations.by_joint = memory.take(3, size.driven ? model.laws.sets.phis() : 0);
  room.rows = memory.take(size.all_rows() + 1, size.row_stride());
  if (room.rows) room.rows += size.row_start();
  room.walk = memory.take(size.driven);
  room.kick = memory.take(size.nuisances + model.laws.axes.momenta, size.nuisances);
  room.covariance = memory.take(size.nuisances, size.nuisances);
  room.x = memory.take(size.nuisances);
  room.y = memory.take(size.parameters);
  room.phi = memory.take(size.shown);
  room.beta = memory.take(2, size.betas());
  const int most = size.betas() > size.parameters ? size.betas() : size.parameters;
  room.transposed = memory.take(TILE, most);
  room.shown = memory.take(TILE, size.shown + 1);
  room.block = memory.take(BLOCK, size.beta_stride());
  return room;
}

// Nothing is known but the prior of beta, `root (beta - beta_0)` of unit variance, `root` k x k in
// the order of beta, and of the nuisances their values x, hardly at all.
inline void begin(const FilterModel& model, Real t, const Matrix& R_WB, const Real* beta_0,
                  const Real* root, const Real* x, FilterState& state, FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const int n = size.nuisances, y = size.parameters, k = size.betas(), stride = size.beta_stride();
  const ConservationModel& laws = model.laws;
  *state.t = t;
  *state.linear = 0.0;
  for (int i = 0; i < 3; ++i) state.w[i] = NOT_A_NUMBER;
  for (int i = 0; i < size.driven; ++i) {
    state.impulse[i] = NOT_A_NUMBER;
    state.q[i] = state.qd[i] = 0;
  }
  for (int i = 0; i < size.driven * size.top_stride(); ++i) state.slope[i] = 0.0;
  for (int i = 0; i < 9; ++i) state.R_WB[i] = R_WB(i / 3, i % 3);
  for (long i = 0; i < static_cast<long>(n) * size.top_stride(); ++i) state.top[i] = 0.0;
  for (long i = 0; i < static_cast<long>(y) * size.R_stride(); ++i) state.R[i] = 0.0;
  for (long i = 0; i < static_cast<long>(k) * stride; ++i) state.prior[i] = 0.0;
  for (int first = 0; first < k; first += BLOCK) {
    const int count = k - first < BLOCK ? k - first : BLOCK;
    for (int i = 0; i < count * stride; ++i) room.block[i] = 0.0;
    for (int i = 0; i < count; ++i) {
      Real* const row = room.block + i * stride;
      const Real* const given = root + static_cast<long>(first + i) * k;
      for (int j = 0; j < k; ++j) {
        row[j < size.shown ? size.iotas + j : j - size.shown] = given[j];
        row[k] += given[j] * beta_0[j];
      }
    }
    fold(state.prior, stride, room.block, stride, count, stride, k);
  }
  for (long i = 0; i < static_cast<long>(k) * stride; ++i) state.root[i] = state.prior[i];
  for (int i = 0; i < k; ++i) state.beta[i] = beta_0[i];

  Real h = 0.0;
  for (int i = 0; i < laws.axes.momenta; ++i) h += x[i] * x[i];
  h = std::sqrt(h);
  const Real far = MOMENTUM_UNKNOWN * (h > 1 ? h : 1);
  const int p = laws.joint_momentum(), b_g = laws.gyro_bias(), b_a = laws.accelerometer_bias();
  const int drives = laws.drives();
  for (int i = 0; i < n; ++i) {
    const Real std = i < laws.axes.momenta ? far
                     : i < p               ? FASTEST
                     : i < b_g             ? far
                     : i < b_a             ? laws.noise.gyro_bias
                     : i < drives
                         ? laws.noise.accelerometer_bias
                         : laws.driven.each[(i - drives) / DRIVES].std[(i - drives) % DRIVES];
    Real* const row = state.top + i * size.top_stride();
    state.x[i] = x[i];
    row[i] = 1 / std;
    row[n + y] = x[i] / std;
  }
}

// The filter before its first sample, which sets the scale of the momentum and is not used up.
// `h_cm` is the momentum where it is known (Eqs. 25 and 26), inertial axes, N m s; else null.
inline void start(const FilterModel& model, const Real* beta_0, const Real* root,
                  const Real* packed, const Real* h_cm, FilterState& state, FilterRoom& room) {
  const FilterSizes size = model.sizes();
  const ConservationModel& laws = model.laws;
  const Measurement at = measurement_at(laws.robot, packed);
  const Matrix R_WB = quaternion_matrix<Real>(Quaternion<Real>(at.x_WB));
  // R_0 (D w + D_q qd + A_rw qd_rw) (Eq. 2).
  Bodies<Real>& bodies = room.equations.bodies;
  configure_beta(laws, beta_0, at.q, room.equations);
  const SystemInertia<Real> all = system_inertia(bodies.carried[0]);
  Vector h = all.D * Vector(at.w[0], at.w[1], at.w[2]) + wheel_momentum(laws.robot, at.qd_rw);
  for (int k = 0; k < laws.robot.tree.joints; ++k)
    h += at.qd[k] * (bodies.momentum[k].h - all.r_cm.cross(bodies.momentum[k].p));
  h = R_WB * h - given_momentum(at);
  if (h_cm) h = Vector(h_cm[0], h_cm[1], h_cm[2]);
  Real* const x = room.x;
  for (int i = 0; i < size.nuisances; ++i) x[i] = 0.0;
  for (int i = laws.drives(); i < size.nuisances; ++i)
    x[i] = laws.driven.each[(i - laws.drives()) / DRIVES].known[(i - laws.drives()) % DRIVES];
  for (int i = 0; i < laws.axes.momenta; ++i) x[i] = h[laws.axes.momentum[i]];
  for (int i = 0; i < laws.axes.velocities; ++i) {
    const Real v = at.v_S[laws.axes.velocity[i]];
    x[laws.axes.momenta + i] = std::isfinite(v) ? v : Real(0);
  }
  begin(model, NOT_A_NUMBER, R_WB, beta_0, root, x, state, room);
  if (!h_cm) return;
  for (int i = 0; i < laws.axes.momenta; ++i) {
    Real* const row = state.top + i * size.top_stride();
    row[i] = 1 / EXACT_MOMENTUM;
    row[size.nuisances + size.parameters] = x[i] / EXACT_MOMENTUM;
  }
}

}  // namespace orbident
