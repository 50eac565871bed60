// Maximum likelihood by output error: a recording's equations, linearised and eliminated.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <vector>

#include "arrays.hpp"
#include "orbident/elimination.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

constexpr std::size_t SENSORS = 6;
constexpr const char* SENSOR[SENSORS] = {"gyro",   "accelerometer", "attitude",
                                         "joints", "position",      "velocity"};

// Indices that Python gives as float64.
std::vector<int> indices(const In<1>& given) {
  return {given.data(), given.data() + given.size(0)};
}

struct OwnedRecorded {
  OwnedTree tree;
  In<1> nominal;
  OwnedSparse theta_of;
  bool planar;
  int substeps;
  std::vector<int> corrected, edge;
  In<1> t;
  In<2> q, qd, qdd, A_rw, qd_rw, qdd_rw;
  std::vector<In<2>> samples;
  In<1> first, prior, walk;
  int lasting;

  std::int64_t axes(std::size_t sensor) const {
    return sensor == 3 ? static_cast<std::int64_t>(tree.joints.size()) : 3;
  }

  Recorded<double> view(int calibrations = 0) const {
    Recorded<double> all{};
    all.tree = tree.view();
    all.theta_of = theta_of.view();
    all.planar = planar;
    all.substeps = substeps;
    all.corrected = corrected.data();
    all.columns = {static_cast<int>(corrected.size()), all.theta_of.columns, calibrations};
    all.rows = static_cast<int>(t.size(0));
    all.t = t.data();
    all.edge = edge.data();
    all.intervals = static_cast<int>(edge.size()) - 1;
    all.q = q.data();
    all.qd = qd.data();
    all.qdd = qdd.data();
    all.wheels = static_cast<int>(A_rw.size(0));
    all.A_rw = A_rw.data();
    all.qd_rw = qd_rw.data();
    all.qdd_rw = qdd_rw.data();
    all.lasting = lasting;
    all.first = first.data();
    all.prior = prior.data();
    all.walk = walk.data();
    return all;
  }
};

Sensed<double>* sensors_of(Recorded<double>& all, std::size_t sensor) {
  Sensed<double>* const each[SENSORS] = {&all.gyro,   &all.accelerometer, &all.attitude,
                                         &all.joints, &all.position,      &all.velocity};
  return each[sensor];
}

OwnedRecorded make_recorded(const OwnedTree& tree, const Array& nominal, const Array& theta_of, bool planar, int substeps,
                            const Array& corrected, const Array& t_, const Array& edge_,
                            const Array& q, const Array& qd, const Array& qdd, const Array& A_rw_,
                            const Array& qd_rw, const Array& qdd_rw,
                            const std::vector<Array>& samples, const Array& first,
                            const Array& prior, const Array& walk) {
  const std::int64_t K = tree.view().joints;
  const auto A_rw = input<2>("A_rw", A_rw_, {ANY, 3});
  const std::int64_t W = A_rw.size(0);
  const auto t = input<1>("t", t_, {ANY});
  const std::int64_t rows = t.size(0), nodes = 2 * rows - 1;
  if (rows < 2) throw nb::value_error("t: give two rows at least");
  const auto edge = indices(input<1>("edge", edge_, {ANY}));
  if (edge.size() < 2 || edge.front() != 0 || edge.back() != rows)
    throw nb::value_error("edge: the first must be 0 and the last the number of rows");
  for (std::size_t k = 1; k < edge.size(); ++k)
    if (edge[k] <= edge[k - 1]) throw nb::value_error("edge: an interval has no rows");
  const auto with_corrections = indices(input<1>("corrected", corrected, {ANY}));
  for (std::size_t k = 0; k < with_corrections.size(); ++k)
    if (with_corrections[k] >= K || with_corrections[k] < 0 ||
        (k > 0 && with_corrections[k] <= with_corrections[k - 1]))
      throw nb::value_error("corrected: give indices of joints, in increasing order");
  if (substeps < 1 || (substeps > 1 && substeps % 2))
    throw nb::value_error("substeps: give 1 or an even number");
  const std::int64_t C = static_cast<std::int64_t>(with_corrections.size());
  const auto of_first = input<1>("first", first, {ANY});
  const std::int64_t lasting = of_first.size(0) - BIASES - 2 * C;
  if (lasting < 0) throw nb::value_error("first: give one number for each unknown of a boundary");
  OwnedRecorded all{tree,
                    input<1>("nominal", nominal, {PER_BODY * (K + 1)}),
                    sparse(input<2>("theta_of", theta_of, {PER_BODY * (K + 1), ANY})),
                    planar,
                    substeps,
                    with_corrections,
                    edge,
                    t,
                    input<2>("q", q, {nodes, K}),
                    input<2>("qd", qd, {nodes, K}),
                    input<2>("qdd", qdd, {nodes, K}),
                    A_rw,
                    input<2>("qd_rw", qd_rw, {nodes, W}),
                    input<2>("qdd_rw", qdd_rw, {nodes, W}),
                    {},
                    of_first,
                    input<1>("prior", prior, {2 * C}),
                    input<1>("walk", walk, {BIASES}),
                    static_cast<int>(lasting)};
  if (samples.size() != SENSORS) throw nb::value_error("samples: give one array a sensor");
  for (std::size_t k = 0; k < SENSORS; ++k) {
    const bool absent = samples[k].ndim() > 0 && samples[k].shape(0) == 0;
    const std::int64_t axes = std::string(SENSOR[k]) == "attitude" ? 4 : all.axes(k);
    all.samples.push_back(
        input<2>(SENSOR[k], samples[k], {absent ? 0 : rows, absent ? ANY : axes}));
  }
  return all;
}

void use(const Bodies<double>& bodies, std::vector<Momentum<double>>& carried,
         std::vector<MomentumTerms<double>>& by, TermsMemory<double>& memory) {
  memory.at = bodies;
  memory.carried_momentum = carried.data();
  memory.by_q = by.data();
  memory.by_qd = by.data() + by.size() / 2;
}

// Memory for one end of the elimination.
class OwnedSweep {
 public:
  explicit OwnedSweep(const Recorded<double>& all) : bodies_(all.tree) {
    const int K = all.tree.joints, n = all.stride(), unknowns = all.columns.count();
    int longest = 0;
    for (int k = 0; k < all.intervals; ++k)
      longest = std::max(longest, all.edge[k + 1] - all.edge[k]);
    carried_.resize(static_cast<std::size_t>(K + 1));
    by_.resize(2 * static_cast<std::size_t>(K));
    IntervalMemory<double>& interval = at.interval;
    use(bodies_.at, carried_, by_, interval.terms);
    interval.q = take(K);
    interval.qd = take(K);
    interval.qdd = take(K);
    for (int k = 0; k < 3; ++k) {
      interval.node[k].by = take(BY_ROWS * unknowns);
      BaseNode<double>& base = interval.base[k];
      base.G = take(3 * unknowns);
      base.phi = take(3 * unknowns);
      base.dw = take(3 * unknowns);
      base.own_by = take(all.substeps > 1 ? BY_R * unknowns : 0);
      interval.velocity[k] = take(3 * unknowns);
    }
    for (auto& sensor : interval.whitening)
      for (Whitening<double>& axis : sensor)
        for (double*& mean : axis.mean) mean = take(all.lasting ? n : 0);
    interval.slopes = take(3 * unknowns);
    interval.felt = take(3 * unknowns);
    at.R = take(std::ptrdiff_t(all.width()) * n);
    at.known = take(std::ptrdiff_t(all.local()) * n);
    at.rows = take(std::ptrdiff_t(5 * 3 * longest + all.lasting) * n);
    at.continuity = take(BIASES * n);
  }
  OwnedSweep(const OwnedSweep&) = delete;
  SweepMemory<double> at;

 private:
  double* take(std::ptrdiff_t count) {
    return room_.emplace_back(static_cast<std::size_t>(count), 0.0).data();
  }
  BodiesMemory<double> bodies_;
  std::vector<Momentum<double>> carried_;
  std::vector<MomentumTerms<double>> by_;
  std::vector<std::vector<double>> room_;
};

// The arguments of a linearisation, checked, and where its residuals go.
struct Call {
  std::vector<int> selected;
  OwnedTree tree;
  Recorded<double> recorded;
  In<2> x_WB, local;
  In<1> common;
  std::vector<In<2>> weights;
  std::vector<Out<2>> residuals;
  std::vector<double> theta, calibration;
  Coloured<double> coloured[TRACKERS][3];
  In<3> acting;
  std::vector<int> gains;

  Call(const OwnedRecorded& owned, const std::vector<Array>& given, const Array& coloured_,
       const Array& acting_,
       const Array& x_WB_, const Array& local_, const Array& common_, const Array& selected_)
      : selected(indices(input<1>("selected", selected_, {ANY}))),
        tree(owned.tree),
        recorded(owned.view(static_cast<int>(selected.size()))),
        x_WB(input<2>("x_WB", x_WB_, {recorded.intervals + 1, 4})),
        local(input<2>("local", local_, {recorded.intervals + 1, recorded.local()})),
        common(input<1>("common", common_, {recorded.common()})),
        theta(owned.nominal.data(), owned.nominal.data() + owned.nominal.size(0)),
        calibration(static_cast<std::size_t>(recorded.places().count()), 0.0),
        acting(input<3>("acting", acting_, {ANY, ACTING_ROWS, ANY})) {
    if (given.size() != SENSORS) throw nb::value_error("weights: give one array a sensor");
    for (std::size_t k = 0; k < SENSORS; ++k) {
      const std::int64_t rows = owned.samples[k].size(0), axes = rows ? owned.axes(k) : ANY;
      weights.push_back(input<2>("weights", given[k], {rows, axes}));
      residuals.emplace_back(rows, owned.axes(k));
      std::fill_n(residuals[k].data(), rows * owned.axes(k), 0.0);
      if (rows)
        *sensors_of(recorded, k) = {owned.samples[k].data(), weights[k].data(),
                                    residuals[k].data(), nullptr, 0};
    }
    colour(coloured_);
    const double* value = common.data() + OUTSIDE + recorded.columns.betas;
    for (std::size_t k = 0; k < selected.size(); ++k, ++value) {
      if (selected[k] < 0) throw nb::value_error("selected: there is no calibration at this place");
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
  void act() {
    const int count = static_cast<int>(gains.size()), betas = recorded.columns.betas;
    if (acting.size(0) == 0 && count == 0) return;
    if (acting.size(0) != 2 * recorded.rows - 1 || acting.size(2) != 1 + count + betas)
      throw nb::value_error(
          "acting: give a table for each node, with columns for its value, each selected gain and beta");
    recorded.acting = {acting.data(), gains.data(), count, recorded.columns.beta(), betas};
  }
  // By tracker and axis: std, time and walk of what lasts.
  void colour(const Array& given) {
    const auto all = input<3>("coloured", given, {TRACKERS, 3, 3});
    Sensed<double>* const trackers[TRACKERS] = {&recorded.attitude, &recorded.position};
    int place = BIASES;
    for (int k = 0; k < TRACKERS; ++k) {
      int parts = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double* values = all.data() + 9 * k + 3 * axis;
        coloured[k][axis] = {values[0], values[1], values[2]};
        parts += coloured[k][axis].parts();
      }
      if (parts && !trackers[k]->values) throw nb::value_error("coloured: of an absent sensor");
      trackers[k]->lasting = place;
      trackers[k]->coloured = parts ? coloured[k] : nullptr;
      place += parts;
    }
    if (place - BIASES != recorded.lasting)
      throw nb::value_error("coloured: has another number of parts than `first`");
  }
  LinearisedAt<double> at() const {
    return {x_WB.data(), local.data(), common.data(), theta.data(),
            {recorded.places(), selected.data(), calibration.data()}};
  }
};

auto linearised(const OwnedRecorded& owned, const std::vector<Array>& weights,
                const Array& coloured, const Array& acting, const Array& x_WB, const Array& local, const Array& common, const Array& selected, int threads) {
  Call call(owned, weights, coloured, acting, x_WB, local, common, selected);
  const Recorded<double>& all = call.recorded;
  const std::int64_t left = all.width() - all.local();
  Out<2> factor(left, left);
  Out<3> links(all.intervals, all.local(), all.width());
  double cost[2] = {0.0, 0.0};
  {
    nb::gil_scoped_release release;
    OwnedSweep forward(all), backward(all);
    parallel_for(2, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      for (std::ptrdiff_t k = first; k < last; ++k)
        cost[k] = sweep(all, call.at(), k == 0, k == 0 ? forward.at : backward.at, links.data());
    }, 1);
    join(all, forward.at, backward.at, factor.data());
  }
  std::vector<Out<2>::Numpy> residuals;
  for (Out<2>& table : call.residuals) residuals.push_back(table.give());
  return std::make_tuple(factor.give(), links.give(), cost[0] + cost[1], residuals);
}

// The equations of one interval over [z start | z end | g | right-hand side].
auto interval_equations(const OwnedRecorded& owned, const std::vector<Array>& weights,
                        const Array& coloured, const Array& acting, const Array& x_WB, const Array& local, const Array& common,
                        const Array& selected, int interval) {
  Call call(owned, weights, coloured, acting, x_WB, local, common, selected);
  const Recorded<double>& all = call.recorded;
  if (interval < 0 || interval >= all.intervals)
    throw nb::value_error("interval: there is none of this number");
  const int L = all.local(), n = all.stride(), width = all.width();
  OwnedSweep memory(all);
  EquationTable<double> sensed{memory.at.rows, n, width, 0, L, L, all.corrections(), 0, 0.0};
  EquationTable<double> continuity{memory.at.continuity, n, width, 0, L, L, all.corrections(), 0, 0.0};
  linearise(all, call.at(), interval, memory.at.interval, sensed, continuity);
  add_encoders(all, call.at(), interval, true, memory.at.R);
  Out<2> table(sensed.rows + BIASES + 2 * L, width);
  double* to = table.data();
  for (const auto& [from, rows] : {std::pair<const double*, int>{sensed.table, sensed.rows},
                                   {continuity.table, BIASES},
                                   {memory.at.R, 2 * L}})
    for (int k = 0; k < rows; ++k, to += width) std::copy_n(from + std::ptrdiff_t(k) * n, width, to);
  return table.give();
}

auto momentum_terms(const OwnedTree& owned, const Array& theta_of_, const Array& beta_,
                    const Array& q_, const Array& qd_, const Array& qdd_) {
  const Tree tree = owned.view();
  const std::int64_t K = tree.joints, B = tree.bodies();
  const auto dense = input<2>("theta_of", theta_of_, {PER_BODY * B, ANY});
  const OwnedSparse theta_of = sparse(dense);
  const auto beta = input<1>("beta", beta_, {dense.size(1)});
  const auto q = input<1>("q", q_, {K}), qd = input<1>("qd", qd_, {K}), qdd = input<1>("qdd", qdd_, {K});
  const Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> of(
      dense.data(), dense.size(0), dense.size(1));
  const Eigen::VectorXd theta = of * Eigen::Map<const Eigen::VectorXd>(beta.data(), beta.size(0));
  BodiesMemory<double> bodies(tree);
  std::vector<Momentum<double>> carried(static_cast<std::size_t>(B));
  std::vector<MomentumTerms<double>> by(2 * static_cast<std::size_t>(K));
  TermsMemory<double> memory;
  use(bodies.at, carried, by, memory);
  const auto all = joint_moments(tree, theta.data(), q.data(), qd.data(), memory);
  differentiate_by_joints(tree, memory);
  // Columns: terms, rates, by q, by qd, by beta.
  const std::int64_t columns = 2 + 2 * K + beta.size(0);
  Out<2> table(BY_ROWS, columns);
  const auto write = [&](const MomentumTerms<double>& terms, std::int64_t column) {
    write_change(terms, table.data() + column, columns);
  };
  write(about_cm(all), 0);
  write(rates_of(tree, qd.data(), qdd.data(), memory), 1);
  for (std::int64_t k = 0; k < 2 * K; ++k) write(by[static_cast<std::size_t>(k)], 2 + k);
  for (int b = 0; b < beta.size(0); ++b)
    write(derivative_by_beta(theta_of.view(), b, all, memory), 2 + 2 * K + b);
  return table.give();
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
      .def("__init__", [](OwnedRecorded* self, const OwnedTree& tree, const Array& nominal,
                          const Array& theta_of, bool planar, int substeps, const Array& corrected, const Array& t,
                          const Array& edge, const Array& q, const Array& qd, const Array& qdd,
                          const Array& A_rw, const Array& qd_rw, const Array& qdd_rw,
                          const std::vector<Array>& samples, const Array& first,
                          const Array& prior, const Array& walk) {
        new (self) OwnedRecorded(make_recorded(tree, nominal, theta_of, planar, substeps, corrected, t, edge,
                                               q, qd, qdd, A_rw, qd_rw, qdd_rw, samples, first,
                                               prior, walk));
      }, nb::arg("tree"), nb::arg("nominal"), nb::arg("theta_of"), nb::arg("planar"), nb::arg("substeps"),
           nb::arg("corrected"), nb::arg("t"), nb::arg("edge"), nb::arg("q"), nb::arg("qd"),
           nb::arg("qdd"), nb::arg("A_rw"), nb::arg("qd_rw"), nb::arg("qdd_rw"),
           nb::arg("samples"), nb::arg("first"), nb::arg("prior"), nb::arg("walk"))
      .def_prop_ro("local", [](const OwnedRecorded& all) { return all.view().local(); },
                   "How many unknowns a boundary has.")
      .def_prop_ro("places", [](const OwnedRecorded& all) { return all.view().places().count(); },
                   "How many calibrations there are; gains are at the places beyond.");
  m.def("linearised", &linearised, nb::arg("recorded"), nb::arg("weights"), nb::arg("coloured"),
        nb::arg("acting"), nb::arg("x_WB"), nb::arg("local"), nb::arg("common"), nb::arg("selected"),
        nb::arg("threads") = 1,
        "All equations at a state, eliminated: factor, links, cost and residuals over the white "
        "noise. `coloured`: of attitude and position, by axis, what lasts: std, time and walk. "
        "`acting`: for each node, what acting.hpp says. `selected`: the places of the calibrations "
        "and, beyond them, of the gains that are common unknowns.");
  m.def("interval_equations", &interval_equations, nb::arg("recorded"), nb::arg("weights"),
        nb::arg("coloured"), nb::arg("acting"), nb::arg("x_WB"), nb::arg("local"),
        nb::arg("common"), nb::arg("selected"), nb::arg("interval"),
        "The equations of one interval over [z start | z end | g | right-hand side].");
  m.def("momentum_terms", &momentum_terms, nb::arg("tree"), nb::arg("theta_of"), nb::arg("beta"),
        nb::arg("q"), nb::arg("qd"), nb::arg("qdd"),
        "D (xx, xy, xz, yy, yz, zz), D_q qd, r_cm, J_cm qd: values, rates, by q, qd and beta.");
  m.def("boundaries", &boundaries_of, nb::arg("links"), nb::arg("z"), nb::arg("g"),
        "The unknowns of every boundary, from those of the meeting one and the common ones.");
}

}  // namespace orbident::python
