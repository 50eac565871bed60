// A recording cut into shooting intervals, checked and owned.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "orbident/elimination.hpp"
#include "robot.hpp"

namespace orbident::python {

constexpr std::size_t SENSORS = 7;
constexpr const char* SENSOR[SENSORS] = {"gyro",     "accelerometer", "attitude", "joints",
                                         "position", "velocity",      "torques"};

// Columns of numbers, each for itself.
struct Columns {
  std::vector<In<1>> each;
  std::vector<const double*> data;

  Columns(const char* name, const std::vector<Array>& given, std::int64_t columns,
          std::int64_t rows) {
    if (static_cast<std::int64_t>(given.size()) != columns)
      throw nb::value_error(
          (std::string(name) + ": give an array for each joint or wheel").c_str());
    for (const Array& column : given) {
      each.push_back(input<1>(name, column, {rows}));
      data.push_back(each.back().data());
    }
  }
};

struct OwnedRecorded {
  OwnedTree tree;
  In<1> theta_0;
  OwnedSparse theta_of;
  bool planar;
  int substeps;
  std::vector<int> corrected, edge;
  In<1> t;
  In<1> knots;
  Columns q, q_slope, qd, qdd, qd_rw, qdd_rw;
  In<2> A_rw;
  std::vector<In<2>> samples;
  In<1> first, corrections, walk;
  int lasting;
  std::vector<Follower> followers;
  std::vector<Spring> springs;
  In<2> laws;
  std::vector<DrivenJoint> driven;
  In<3> over_intervals;

  std::int64_t axes(std::size_t sensor) const {
    return sensor == 3 || sensor == 6 ? static_cast<std::int64_t>(tree.joints.size()) : 3;
  }

  Recorded view(int calibrations = 0) const {
    Recorded all{};
    all.tree = tree.view();
    all.theta_of = theta_of.view();
    all.planar = planar;
    all.substeps = substeps;
    all.corrected = corrected.data();
    all.followers = {followers.data(), static_cast<int>(followers.size())};
    all.columns = {static_cast<int>(corrected.size()), all.theta_of.columns, calibrations};
    all.rows = static_cast<int>(t.size(0));
    all.t = t.data();
    all.edge = edge.data();
    all.intervals = static_cast<int>(edge.size()) - 1;
    all.history = {static_cast<int>(knots.size(0)),
                   knots.data(),
                   q.data.data(),
                   q_slope.data.data(),
                   qd.data.data(),
                   qdd.data.data(),
                   qd_rw.data.data(),
                   qdd_rw.data.data()};
    all.wheels = static_cast<int>(A_rw.size(0));
    all.A_rw = A_rw.data();
    all.lasting = lasting;
    all.spring = springs.data();
    all.springs = static_cast<int>(springs.size());
    all.driven = driven.data();
    all.over_intervals = over_intervals.data();
    all.momentum = -1;
    all.first = first.data();
    all.prior = corrections.data();
    all.walk = walk.data();
    return all;
  }
};

inline Sensed* sensors_of(Recorded& all, std::size_t sensor) {
  Sensed* const each[SENSORS] = {&all.gyro,     &all.accelerometer, &all.attitude, &all.joints,
                                 &all.position, &all.velocity,      &all.torques};
  return each[sensor];
}

inline OwnedRecorded make_recorded(
    const OwnedTree& tree, const Array& theta_0, const Array& theta_of, bool planar, int substeps,
    const Array& corrected, const Array& follows_, const Array& t_, const Array& edge_,
    const Array& knots_, const std::vector<Array>& q, const std::vector<Array>& q_slope,
    const std::vector<Array>& qd, const std::vector<Array>& qdd, const Array& A_rw_,
    const std::vector<Array>& qd_rw, const std::vector<Array>& qdd_rw,
    const std::vector<Array>& samples, const Array& first, const Array& corrections,
    const Array& walk, const Array& passive_, const Array& laws_, const Array& driven_,
    const Array& over_intervals_) {
  const std::int64_t K = tree.view().joints;
  const auto A_rw = input<2>("A_rw", A_rw_, {ANY, 3});
  const std::int64_t W = A_rw.size(0);
  const auto t = input<1>("t", t_, {ANY});
  const auto knots = input<1>("knots", knots_, {ANY});
  const std::int64_t rows = t.size(0), at = knots.size(0);
  if (at < 2) throw nb::value_error("knots: give two at least");
  if (rows < 2) throw nb::value_error("t: give two rows at least");
  const auto edge =
      whole_numbers("edge", input<1>("edge", edge_, {ANY}), static_cast<double>(rows) + 1.0);
  if (edge.size() < 2 || edge.front() != 0 || edge.back() != rows)
    throw nb::value_error("edge: the first must be 0 and the last the number of rows");
  for (std::size_t k = 1; k < edge.size(); ++k)
    if (edge[k] <= edge[k - 1]) throw nb::value_error("edge: an interval has no rows");
  const auto with_corrections =
      whole_numbers("corrected", input<1>("corrected", corrected, {ANY}), static_cast<double>(K));
  for (std::size_t k = 1; k < with_corrections.size(); ++k)
    if (with_corrections[k] <= with_corrections[k - 1])
      throw nb::value_error("corrected: give indices of joints, in increasing order");
  if (substeps < 1 || (substeps > 1 && substeps % 2))
    throw nb::value_error("substeps: give 1 or an even number");
  const std::int64_t C = static_cast<std::int64_t>(with_corrections.size());
  const auto of_first = input<1>("first", first, {ANY});
  const std::int64_t lasting = of_first.size(0) - BIASES - 2 * C;
  if (lasting < 0) throw nb::value_error("first: give one number for each unknown of a boundary");
  OwnedRecorded all{tree,
                    input<1>("theta_0", theta_0, {PER_BODY * (K + 1)}),
                    sparse(input<2>("theta_of", theta_of, {PER_BODY * (K + 1), ANY})),
                    planar,
                    substeps,
                    with_corrections,
                    edge,
                    t,
                    knots,
                    Columns("q", q, K, at),
                    Columns("q_slope", q_slope, K, at),
                    Columns("qd", qd, K, at),
                    Columns("qdd", qdd, K, at),
                    Columns("qd_rw", qd_rw, W, at),
                    Columns("qdd_rw", qdd_rw, W, at),
                    A_rw,
                    {},
                    of_first,
                    input<1>("corrections", corrections, {2 * C}),
                    input<1>("walk", walk, {BIASES}),
                    static_cast<int>(lasting),
                    {},
                    {},
                    {},
                    {},
                    input<3>("over_intervals", over_intervals_,
                             {static_cast<std::int64_t>(edge.size()) - 1, K, 2})};
  const auto correction_of = [&](const char* what, int joint) {
    const auto at = std::find(all.corrected.begin(), all.corrected.end(), joint);
    if (at == all.corrected.end())
      throw nb::value_error((std::string(what) + ": a joint has no corrections").c_str());
    return static_cast<int>(at - all.corrected.begin());
  };
  const auto follows = input<2>("follows", follows_, {ANY, 3});
  for (std::int64_t f = 0; f < follows.size(0); ++f) {
    const double* x = follows.data() + 3 * f;
    for (int k = 0; k < 2; ++k)
      if (!(x[k] >= 0.0 && x[k] < static_cast<double>(K) && x[k] == std::floor(x[k])))
        throw nb::value_error("follows: give indices of joints");
    all.followers.push_back(
        {static_cast<int>(x[0]), correction_of("follows", static_cast<int>(x[1])), x[2]});
  }
  const auto passive =
      whole_numbers("passive", input<1>("passive", passive_, {ANY}), static_cast<double>(K));
  all.laws =
      input<2>("laws", laws_, {static_cast<std::int64_t>(passive.size()), 4 + PER_BODY * (K + 1)});
  for (std::size_t e = 0; e < passive.size(); ++e) {
    const double* law = all.laws.data() + static_cast<std::ptrdiff_t>(e) * all.laws.size(1);
    if (!(law[2] > 0.0 && law[3] > 0.0)) throw nb::value_error("laws: a walk is not above zero");
    all.springs.push_back({passive[e],
                           correction_of("passive", passive[e]),
                           law[0],
                           law[1],
                           {law[2], law[3]},
                           law + 4});
  }
  const auto driven = input<2>("driven", driven_, {K, 4});
  for (std::int64_t k = 0; k < K; ++k) {
    const double* x = driven.data() + 4 * k;
    all.driven.push_back({x[0], x[1], x[2], x[3]});
  }
  if (samples.size() != SENSORS) throw nb::value_error("samples: give one array a sensor");
  for (std::size_t k = 0; k < SENSORS; ++k) {
    const bool absent = samples[k].ndim() > 0 && samples[k].shape(0) == 0;
    const std::int64_t axes = std::string(SENSOR[k]) == "attitude" ? 4 : all.axes(k);
    all.samples.push_back(
        input<2>(SENSOR[k], samples[k], {absent ? 0 : rows, absent ? ANY : axes}));
  }
  return all;
}

}  // namespace orbident::python
