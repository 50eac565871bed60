// Maximum likelihood by output error: a recording's equations, linearised and eliminated.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "linearisation.hpp"
#include "orbident/changes.hpp"
#include "orbident/parallel.hpp"

namespace orbident::python {
namespace {

// Whether two recordings give equations row by row.
bool alike(const Recorded& one, const Recorded& other) {
  const auto sensors = [](const Recorded& all) {
    return std::array{all.gyro.values != nullptr,     all.accelerometer.values != nullptr,
                      all.attitude.values != nullptr, all.joints.values != nullptr,
                      all.position.values != nullptr, all.velocity.values != nullptr,
                      all.torques.values != nullptr};
  };
  return one.rows == other.rows && one.intervals == other.intervals &&
         std::equal(one.edge, one.edge + one.intervals, other.edge) &&
         one.tree.joints == other.tree.joints && one.local() == other.local() &&
         one.springs == other.springs && sensors(one) == sensors(other);
}

auto linearised(const OwnedRecorded& owned, const std::vector<Array>& weights,
                const Array& coloured, const Array& acting, const Array& x_WB, const Array& local,
                const Array& common, const Array& selected, int threads, bool factor_only) {
  Call call(owned, weights, coloured, acting, x_WB, local, common, selected, !factor_only);
  const Recorded& all = call.recorded;
  const std::int64_t left = all.width() - all.local();
  Out<2> factor(left, left);
  Out<3> links(factor_only ? 0 : all.intervals, all.local(), all.width());
  double cost[2] = {0.0, 0.0};
  {
    nb::gil_scoped_release release;
    OwnedSweep forward(all, call.selected), backward(all, call.selected);
    parallel_for(2, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      for (std::ptrdiff_t k = first; k < last; ++k)
        cost[k] = sweep(all, call.at(), k == 0, k == 0 ? forward.at : backward.at,
                        factor_only ? nullptr : links.data());
    }, 1);
    join(all, forward.at, backward.at, factor.data());
  }
  std::vector<Out<2>::Numpy> residuals;
  for (Out<2>& table : call.residuals) residuals.push_back(table.give());
  return std::make_tuple(factor.give(), links.give(), cost[0] + cost[1], residuals);
}

// Of a changed recording: it, what acts on it, the common unknowns and which of them are selected.
using Changed = std::tuple<const OwnedRecorded*, Array, Array, Array>;

auto changes_factor(const OwnedRecorded& owned, const std::vector<Array>& weights,
                    const Array& coloured, const Array& acting, const Array& x_WB,
                    const Array& local, const Array& common, const Array& selected,
                    const std::vector<Changed>& changed, const Array& sizes_, int threads) {
  Call call(owned, weights, coloured, acting, x_WB, local, common, selected, false);
  const std::size_t count = changed.size();
  const auto sizes = input<1>("sizes", sizes_, {static_cast<std::int64_t>(count)});
  std::vector<std::unique_ptr<Call>> calls;
  for (const auto& [other, acts, values, chosen] : changed) {
    if (!other) throw nb::value_error("changed: give recordings");
    calls.push_back(std::make_unique<Call>(*other, weights, coloured, acts, x_WB, local, values,
                                           chosen, false));
    if (!alike(call.recorded, calls.back()->recorded))
      throw nb::value_error("changed: a recording has other rows, intervals or sensors");
  }
  Recorded& all = call.recorded;
  std::vector<std::vector<double>> sides(count);
  std::vector<const double*> each(count);
  std::vector<std::ptrdiff_t> first;
  std::vector<double> changed_by(sizes.data(), sizes.data() + count);
  all.changes = {static_cast<int>(count), each.data(), changed_by.data(), nullptr};
  const std::int64_t left = all.width() - all.local();
  Out<2> factor(left, left);
  {
    nb::gil_scoped_release release;
    parallel_for(static_cast<std::ptrdiff_t>(count), threads,
                 [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
      for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
        const Recorded alone = calls[k]->without_common();
        OwnedSweep memory(alone, calls[k]->selected);
        auto begins = right_hand_sides(alone, calls[k]->at(), memory.at, sides[k]);
        if (!std::all_of(sides[k].begin(), sides[k].end(),
                         [](double x) { return std::isfinite(x); })) {
          // What overflows says nothing.
          std::fill(sides[k].begin(), sides[k].end(), 0.0);
          changed_by[k] = std::numeric_limits<double>::infinity();
        }
        each[k] = sides[k].data();
        if (k == 0) first = std::move(begins);
      }
    }, 1);
    all.changes.first = first.data();
    OwnedSweep forward(all, call.selected), backward(all, call.selected);
    parallel_for(2, threads, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
      for (std::ptrdiff_t k = begin; k < end; ++k)
        sweep(all, call.at(), k == 0, k == 0 ? forward.at : backward.at, nullptr);
    }, 1);
    join(all, forward.at, backward.at, factor.data());
  }
  return factor.give();
}

// The equations of one interval over [z start | z end | g | right-hand side].
auto interval_equations(const OwnedRecorded& owned, const std::vector<Array>& weights,
                        const Array& coloured, const Array& acting, const Array& x_WB,
                        const Array& local, const Array& common, const Array& selected,
                        int interval) {
  Call call(owned, weights, coloured, acting, x_WB, local, common, selected, false);
  const Recorded& all = call.recorded;
  if (interval < 0 || interval >= all.intervals)
    throw nb::value_error("interval: there is none of this number");
  const int L = all.local(), n = all.stride(), width = all.width();
  OwnedSweep memory(all, call.selected);
  EquationTable sensed = memory.at.sensed(all, true), continuity = memory.at.continued(all, true);
  linearise(all, call.at(), interval, memory.at.interval, sensed, continuity);
  add_encoders(all, call.at(), interval, true, 0, memory.at.encoders, memory.at.R);
  Out<2> table(sensed.rows + continuity.rows + 2 * L, width);
  double* to = table.data();
  for (const auto& [from, rows] : {std::pair<const double*, int>{sensed.table, sensed.rows},
                                   {continuity.table, continuity.rows},
                                   {memory.at.R, 2 * L}})
    for (int k = 0; k < rows; ++k, to += width)
      std::copy_n(from + std::ptrdiff_t(k) * n, width, to);
  return table.give();
}

auto momentum_terms(const OwnedTree& owned, const Array& theta_of_, const Array& beta_,
                    const Array& q_, const Array& qd_, const Array& qdd_) {
  const Tree tree = owned.view();
  const std::int64_t K = tree.joints, B = tree.bodies();
  const auto dense = input<2>("theta_of", theta_of_, {PER_BODY * B, ANY});
  const OwnedSparse theta_of = sparse(dense);
  const auto beta = input<1>("beta", beta_, {dense.size(1)});
  const auto q = input<1>("q", q_, {K}), qd = input<1>("qd", qd_, {K}),
             qdd = input<1>("qdd", qdd_, {K});
  const Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> of(
      dense.data(), dense.size(0), dense.size(1));
  const Eigen::VectorXd theta = of * Eigen::Map<const Eigen::VectorXd>(beta.data(), beta.size(0));
  BodiesMemory<double> bodies(tree);
  std::vector<Momentum<double>> carried(static_cast<std::size_t>(B));
  std::vector<MomentumTerms> by(2 * static_cast<std::size_t>(K));
  TermsMemory memory;
  use(bodies.at, carried, by, memory);
  const auto all = joint_moments(tree, theta.data(), q.data(), qd.data(), memory);
  differentiate_by_joints(tree, memory);
  // Columns: terms, rates, by q, by qd, by beta.
  const std::int64_t columns = 2 + 2 * K + beta.size(0);
  Out<2> table(BY_ROWS, columns);
  const auto write = [&](const MomentumTerms& terms, std::int64_t column) {
    write_change(terms, table.data() + column, columns);
  };
  write(about_cm(all), 0);
  write(rates_of(tree, qd.data(), qdd.data(), memory), 1);
  for (std::int64_t k = 0; k < 2 * K; ++k) write(by[static_cast<std::size_t>(k)], 2 + k);
  for (int b = 0; b < beta.size(0); ++b)
    write(derivative_by_beta(theta_of.view(), b, all, memory), 2 + 2 * K + b);
  return table.give();
}

auto joint_momenta_of(const OwnedTree& owned, const Array& theta_of_, const Array& beta_,
                      const Array& q_, const Array& qd_, const Array& w_) {
  const Tree tree = owned.view();
  const std::int64_t K = tree.joints, B = tree.bodies();
  const auto dense = input<2>("theta_of", theta_of_, {PER_BODY * B, ANY});
  const OwnedSparse theta_of = sparse(dense);
  const auto beta = input<2>("beta", beta_, {ANY, dense.size(1)});
  const std::int64_t states = beta.size(0), numbers = beta.size(1), rows = 3 + 2 * K;
  const auto q = input<2>("q", q_, {states, K}), qd = input<2>("qd", qd_, {states, K}),
             w = input<2>("w", w_, {states, 3});
  const Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> of(
      dense.data(), dense.size(0), dense.size(1));
  const DirectionPlaces places{static_cast<int>(K), static_cast<int>(numbers), 0};
  OwnedJointMomenta memory(tree, places.count());
  Out<3> tables(states, rows, 1 + places.count());
  double* row = tables.data();
  for (std::int64_t n = 0; n < states; ++n) {
    const Eigen::VectorXd theta =
        of * Eigen::Map<const Eigen::VectorXd>(beta.data() + n * numbers, numbers);
    pose_and_weigh(tree, theta.data(), q.data() + n * K, memory.at.bodies);
    joint_momenta(tree, qd.data() + n * K, Vector3<double>(w.data() + 3 * n), memory.at);
    differentiate_joint_momenta(tree, theta_of.view(), places, nullptr, nullptr, memory.at);
    for (std::int64_t k = 0; k < rows; ++k, row += 1 + places.count()) {
      row[0] = memory.at.values[k];
      std::copy_n(memory.at.slopes + k * places.count(), places.count(), row + 1);
    }
  }
  return tables.give();
}

auto boundaries_of(const Array& links_, const Array& z_, const Array& g_) {
  const auto links = input<3>("links", links_, {ANY, ANY, ANY});
  const std::int64_t intervals = links.size(0), L = links.size(1), width = links.size(2);
  const auto z = input<1>("z", z_, {L});
  const auto g = input<1>("g", g_, {width - 2 * L - 1});
  Out<2> every(intervals + 1, L);
  const int count = static_cast<int>(intervals);
  std::copy_n(z.data(), L, every.data() + meeting_boundary(count) * L);
  boundaries(links.data(), count, static_cast<int>(L), static_cast<int>(width), g.data(),
             every.data());
  return every.give();
}

}  // namespace

void bind_output_error(nb::module_& m) {
  nb::class_<OwnedRecorded>(m, "Recorded", "A recording cut into shooting intervals.")
      .def(nb::new_(&make_recorded), nb::kw_only(), nb::arg("tree"), nb::arg("theta_0"),
           nb::arg("theta_of"), nb::arg("planar"), nb::arg("substeps"), nb::arg("corrected"),
           nb::arg("follows"), nb::arg("t"), nb::arg("edge"), nb::arg("knots"), nb::arg("q"),
           nb::arg("q_slope"), nb::arg("qd"), nb::arg("qdd"), nb::arg("A_rw"), nb::arg("qd_rw"),
           nb::arg("qdd_rw"), nb::arg("samples"), nb::arg("first"), nb::arg("corrections"),
           nb::arg("walk"), nb::arg("passive"), nb::arg("laws"), nb::arg("driven"),
           nb::arg("over_intervals"),
           "theta = theta_0 + theta_of beta. `follows`: a joint, the one with corrections that it "
           "follows, and by which factor. Standard deviations: `first` of the unknowns of "
           "the first boundary, `corrections` of those of joints anywhere, `walk` of what "
           "attitude and biases walk in a second. `passive`: joints that nobody measures; "
           "`laws` of each: squared rate, damping rate, walks of its position and rate, and by "
           "theta the inertia that it carries. `driven`: what each joint's motor and friction "
           "are taken to have, A, d, c and o of joint_torques.hpp; `over_intervals`: of "
           "torques in each interval, the mean of the rate's sign, and by how much they change a "
           "second.")
      .def_prop_ro("local", [](const OwnedRecorded& all) { return all.view().local(); },
                   "How many unknowns a boundary has.")
      .def_prop_ro("places", [](const OwnedRecorded& all) { return all.view().places().count(); },
                   "How many calibrations there are; gains are at the places beyond.");
  m.def("linearised", &linearised, nb::arg("recorded"), nb::kw_only(), nb::arg("weights"),
        nb::arg("coloured"), nb::arg("acting"), nb::arg("x_WB"), nb::arg("local"),
        nb::arg("common"), nb::arg("selected"), nb::arg("threads") = 1,
        nb::arg("factor_only") = false,
        "All equations at a state, eliminated: factor, links, cost and residuals over the white "
        "noise; links and residuals are empty where the factor alone is asked for. `coloured`: of "
        "attitude and position, by axis, what lasts: std, time, walk and walk of its rate. "
        "`acting`: for each node, what acting.hpp says. `selected`: the places of the calibrations "
        "and, beyond them, of the gains that are common unknowns.");
  m.def("changes_factor", &changes_factor, nb::arg("recorded"), nb::kw_only(), nb::arg("weights"),
        nb::arg("coloured"), nb::arg("acting"), nb::arg("x_WB"), nb::arg("local"),
        nb::arg("common"), nb::arg("selected"), nb::arg("changed"), nb::arg("sizes"),
        nb::arg("threads") = 1,
        "The factor of `linearised` with a column for each of `changed` before the last: "
        "recordings that differ by `sizes`, each with its own `acting`, `common` and `selected` "
        "at the same state.");
  m.def("interval_equations", &interval_equations, nb::arg("recorded"), nb::kw_only(),
        nb::arg("weights"), nb::arg("coloured"), nb::arg("acting"), nb::arg("x_WB"),
        nb::arg("local"), nb::arg("common"), nb::arg("selected"), nb::arg("interval"),
        "The equations of one interval over [z start | z end | g | right-hand side].");
  m.def("momentum_terms", &momentum_terms, nb::arg("tree"), nb::arg("theta_of"), nb::arg("beta"),
        nb::arg("q"), nb::arg("qd"), nb::arg("qdd"),
        "D (xx, xy, xz, yy, yz, zz), D_q qd, r_cm, J_cm qd: values, rates, by q, qd and beta.");
  m.def("joint_momenta", &joint_momenta_of, nb::arg("tree"), nb::arg("theta_of"), nb::arg("beta"),
        nb::arg("q"), nb::arg("qd"), nb::arg("w"),
        "Momentum of all bodies, momenta of the joints and slopes of the energy by q, at some "
        "states: values, by w, qd, q and beta.");
  m.def("boundaries", &boundaries_of, nb::arg("links"), nb::arg("z"), nb::arg("g"),
        "The unknowns of every boundary, from those of the meeting one and the common ones.");
}

}  // namespace orbident::python
