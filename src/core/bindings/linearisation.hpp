// The arguments and the memory of one linearisation of a recording's equations.
#pragma once

#include <limits>

#include "recorded.hpp"

namespace orbident::python {

inline void use(const Bodies<double>& bodies, std::vector<Momentum<double>>& carried,
                std::vector<MomentumTerms>& by, TermsMemory& memory) {
  memory.at = bodies;
  memory.carried_momentum = carried.data();
  memory.by_q = by.data();
  memory.by_qd = by.data() + by.size() / 2;
}

// Memory for the momenta of joints and their derivatives.
class OwnedJointMomenta {
 public:
  OwnedJointMomenta(const Tree& tree, int directions)
      : bodies_(tree),
        rates_(static_cast<std::size_t>(tree.joints)),
        followed_(2 * static_cast<std::size_t>(tree.joints)),
        more_(static_cast<std::size_t>(tree.bodies())),
        table_(static_cast<std::size_t>((3 + 2 * tree.joints) * (1 + directions))) {
    at = {bodies_.at,       rates_.data(),
          followed_.data(), followed_.data() + tree.joints,
          more_.data(),     table_.data() + 3 + 2 * tree.joints,
          table_.data()};
  }
  OwnedJointMomenta(const OwnedJointMomenta&) = delete;
  JointMomentaMemory at;

 private:
  BodiesMemory<double> bodies_;
  std::vector<Motion<double>> rates_;
  std::vector<Vector3<double>> followed_;
  std::vector<Momentum<double>> more_;
  std::vector<double> table_;
};

// Memory for one end of the elimination.
class OwnedSweep {
 public:
  // `selected`: the places of the calibrations that are unknowns.
  OwnedSweep(const Recorded& all, const std::vector<int>& selected)
      : bodies_(all.tree), places_(all, selected), own_(all.tree, places_.all.count()) {
    const int K = all.tree.joints, n = all.stride(), unknowns = all.columns.count();
    const int P = all.springs, rates = 3 + P, states = 3 + 2 * P;
    int longest = 0;
    for (int k = 0; k < all.intervals; ++k)
      longest = std::max(longest, all.edge[k + 1] - all.edge[k]);
    carried_.resize(static_cast<std::size_t>(K + 1));
    by_.resize(2 * static_cast<std::size_t>(K));
    IntervalMemory& interval = at.interval;
    use(bodies_.at, carried_, by_, interval.terms);
    const auto state = [&]() -> JointState {
      return {take(K), take(K), take(K), take(all.wheels), take(all.wheels)};
    };
    for (JointState& after : interval.after) after = state();
    const auto reads = [&](JointNode& node) {
      node.q = take(K);
      node.qd = take(K);
      node.qdd = take(K);
      node.shown = state();
    };
    for (int k = 0; k < 3; ++k) {
      JointNode& node = interval.node[k];
      node.by = take(BY_ROWS * unknowns);
      reads(node);
      BaseNode& base = interval.base[k];
      base.G = take(states * unknowns);
      base.phi = take(states * unknowns);
      base.dw = take(rates * unknowns);
      passive_[k] = {
          take(P), take(P), take(P), take(P), take(P), take(rates * states), take(states * states)};
      base.passive = &passive_[k];
      base.own_by = take(all.substeps > 1 ? BY_R * unknowns : 0);
      interval.velocity[k] = take(3 * unknowns);
    }
    for (auto& sensor : interval.whitening)
      for (Whitening& axis : sensor)
        for (double*& mean : axis.mean) mean = take(all.lasting ? n : 0);
    interval.slopes = take(3 * unknowns);
    interval.felt = take(3 * unknowns);
    interval.moved = take(3 * unknowns);
    at.R = take(std::ptrdiff_t(all.width()) * n);
    at.known = take(std::ptrdiff_t(all.local()) * n);
    at.rows = take(std::ptrdiff_t(5 * 3 * longest + all.lasting + 3 + K) * n);
    at.continuity = take(std::ptrdiff_t(BIASES + 2 * P) * n);
    at.encoders = take(std::ptrdiff_t(joint_width(all) + BLOCK) * joint_width(all));
    if (!all.own()) return;
    PassiveMemory& own = interval.own;
    own.places = places_.all;
    own.at = own_.at;
    own.geometry = places_.fields.data();
    own.displaced = places_.displaced.data();
    own.place = places_.place.data();
    own.m = take(rates);
    own.D_qq = take(K * K);
    own.inertia = take(rates * rates);
    own.U = take(rates * rates);
    own.H = take(rates * states);
    own.L = take(P * rates);
    own.C = take(states * unknowns);
    own.K = take(states * unknowns);
    own.last = take(states * unknowns);
    own.rates = take(8 * P);
    own.impulse = take(K);
    own.impulse_by = take(K * unknowns);
    own.row = take(unknowns);
    for (JointNode& node : own.joints) reads(node);
  }
  OwnedSweep(const OwnedSweep&) = delete;
  SweepMemory at;

 private:
  double* take(std::ptrdiff_t count) {
    return room_.emplace_back(static_cast<std::size_t>(count), 0.0).data();
  }
  // The directions in which passive joints' motion changes; none where there are no such joints.
  struct Places {
    DirectionPlaces all{0, 0, 0};
    std::vector<int> place, displaced;
    std::vector<Motion<double>> fields;
    Places(const Recorded& recorded, const std::vector<int>& selected) {
      if (!recorded.own()) return;
      const CalibrationPlaces places = recorded.places();
      for (const int each : selected) {
        if (!places.is_geometry(each)) continue;
        place.push_back(each);
        displaced.push_back((each - places.place()) / 3 % places.joints);
      }
      fields.resize(place.size());
      all = {recorded.tree.joints, recorded.columns.betas, static_cast<int>(place.size())};
    }
  };
  BodiesMemory<double> bodies_;
  Places places_;
  OwnedJointMomenta own_;
  PassiveNode passive_[3];
  std::vector<Momentum<double>> carried_;
  std::vector<MomentumTerms> by_;
  std::vector<std::vector<double>> room_;
};

// The arguments of a linearisation, checked, and where its residuals go.
struct Call {
  std::vector<int> selected;
  OwnedTree tree;
  Recorded recorded;
  In<2> x_WB, local;
  In<1> common;
  std::vector<In<2>> weights;
  std::vector<Out<2>> residuals;
  std::vector<double> theta, calibration;
  Coloured coloured[TRACKERS][3];
  In<3> acting;
  std::vector<int> gains;

  Call(const OwnedRecorded& owned, const std::vector<Array>& given, const Array& coloured_,
       const Array& acting_, const Array& x_WB_, const Array& local_, const Array& common_,
       const Array& selected_, bool with_residuals)
      : selected(whole_numbers("selected", input<1>("selected", selected_, {ANY}),
                               std::numeric_limits<int>::max())),
        tree(owned.tree),
        recorded(owned.view(static_cast<int>(selected.size()))),
        x_WB(input<2>("x_WB", x_WB_, {recorded.intervals + 1, 4})),
        local(input<2>("local", local_, {recorded.intervals + 1, recorded.local()})),
        common(input<1>("common", common_, {recorded.common()})),
        theta(owned.theta_0.data(), owned.theta_0.data() + owned.theta_0.size(0)),
        calibration(static_cast<std::size_t>(recorded.places().count()), 0.0),
        acting(input<3>("acting", acting_, {ANY, ACTING_ROWS, ANY})) {
    if (given.size() != SENSORS) throw nb::value_error("weights: give one array a sensor");
    for (std::size_t k = 0; k < SENSORS; ++k) {
      const std::int64_t rows = owned.samples[k].size(0), axes = rows ? owned.axes(k) : ANY;
      weights.push_back(input<2>("weights", given[k], {rows, axes}));
      residuals.emplace_back(with_residuals ? rows : 0, owned.axes(k));
      std::fill_n(residuals[k].data(), with_residuals ? rows * owned.axes(k) : 0, 0.0);
      if (rows)
        *sensors_of(recorded, k) = {owned.samples[k].data(),
                                    weights[k].data(),
                                    with_residuals ? residuals[k].data() : nullptr,
                                    nullptr,
                                    0,
                                    false};
    }
    colour(coloured_);
    const double* value = common.data() + OUTSIDE + recorded.columns.betas;
    for (std::size_t k = 0; k < selected.size(); ++k, ++value) {
      if (selected[k] < recorded.places().count())
        calibration[static_cast<std::size_t>(selected[k])] = *value;
      else
        gains.push_back(recorded.columns.calibration() + static_cast<int>(k));
    }
    act();
    for (std::size_t k = 0; k < tree.joints.size(); ++k) {
      const auto three = [&](int first) {
        return Vector3<double>(calibration.data() + first + 3 * static_cast<int>(k));
      };
      shift(tree.joints[k], three(recorded.places().place()), three(recorded.places().direction()));
    }
    recorded.tree = tree.view();
    const Sparse& theta_of = recorded.theta_of;
    for (int b = 0; b < theta_of.columns; ++b)
      for (int e = theta_of.first[b]; e < theta_of.first[b + 1]; ++e)
        theta[static_cast<std::size_t>(theta_of.row[e])] +=
            theta_of.value[e] * common.data()[OUTSIDE + b];
  }
  // Without columns of what all intervals have in common: where right-hand sides alone are asked.
  Recorded without_common() const {
    Recorded alone = recorded;
    alone.columns.betas = alone.acting.betas = alone.acting.gains = 0;
    alone.columns.calibrations -= static_cast<int>(gains.size());
    return alone;
  }
  void act() {
    const int count = static_cast<int>(gains.size());
    if (acting.size(0) == 0 && count == 0) return;
    const std::int64_t betas = acting.size(2) - 1 - count;
    if (acting.size(0) != 2 * recorded.rows - 1 || (betas != 0 && betas != recorded.columns.betas))
      throw nb::value_error(
          "acting: give a table for each node, with columns for its value, each selected gain and, "
          "where it depends on these, each beta");
    recorded.acting = {acting.data(),
                       gains.data(),
                       count,
                       recorded.columns.beta(),
                       static_cast<int>(betas),
                       static_cast<int>(acting.size(2))};
  }
  // By tracker and axis: std, time, walk and walk of the rate of what lasts.
  void colour(const Array& given) {
    const auto all = input<3>("coloured", given, {TRACKERS, 3, 4});
    Sensed* const trackers[TRACKERS] = {&recorded.attitude, &recorded.position};
    int place = BIASES;
    recorded.attitude.turns = true;
    for (int k = 0; k < TRACKERS; ++k) {
      int parts = 0;
      bool any = false;
      for (int axis = 0; axis < 3; ++axis) {
        const double* values = all.data() + 12 * k + 4 * axis;
        coloured[k][axis] = {values[0], values[1], values[2], values[3]};
        const Coloured& own = coloured[k][axis];
        any |= own.parts() > 0;
        parts += own.parts();
        if (!trackers[k]->turns || !own.has(OFFSET)) continue;
        if (axis < 2 || !recorded.planar)
          throw nb::value_error("coloured: only about the vertical of a planar robot rates walk");
        recorded.momentum = place + --parts - 1;
      }
      if (any && !trackers[k]->values) throw nb::value_error("coloured: of an absent sensor");
      trackers[k]->lasting = place;
      trackers[k]->coloured = any ? coloured[k] : nullptr;
      place += parts;
    }
    if (place - BIASES != recorded.lasting)
      throw nb::value_error("coloured: has another number of parts than `first`");
  }
  LinearisedAt at() const {
    return {x_WB.data(),
            local.data(),
            common.data(),
            theta.data(),
            {recorded.places(), selected.data(), calibration.data()}};
  }
};

}  // namespace orbident::python
