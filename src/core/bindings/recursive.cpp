// The recursive filter and its change detector: one sample, or a whole recording.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include <optional>

#include "arrays.hpp"
#include "orbident/change_detection.hpp"
#include "orbident/information_filter.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

struct OwnedFilter {
  OwnedRobot robot;
  OwnedMinimalSets sets;
  OwnedSparse theta_of, pi_of_shown, pi_of_products;
  std::vector<int> pair;
  ConservedAxes axes;
  SensorNoise noise;
  int pis, sigmas, iotas;

  FilterModel view() const {
    return {{robot.view(), sets.view(), theta_of.view(), axes, noise},
            {pi_of_shown.view(), pi_of_products.view(), pair.data(), pis, sigmas, iotas}};
  }
  int measured() const {
    return measurement_size(static_cast<int>(robot.tree.joints.size()),
                            static_cast<int>(robot.wheels.size()));
  }
};

// Room for steps, as long as a call takes.
class Room {
 public:
  explicit Room(const FilterModel& model) : bodies_(model.laws.robot.tree) {
    Memory count{nullptr};
    room_in(model, bodies_.at, count);
    doubles_.reset(new double[static_cast<std::size_t>(count.used)]);
    Memory memory{doubles_.get()};
    at = room_in(model, bodies_.at, memory);
  }
  FilterRoom at;

 private:
  BodiesMemory<double> bodies_;
  std::unique_ptr<double[]> doubles_;
};

// A state as Python holds it; never written to once it has been handed out.
class OwnedState {
 public:
  explicit OwnedState(const FilterSizes& size) : size(size) {
    Memory count{nullptr};
    state_in(size, count);
    memory_.resize(static_cast<std::size_t>(count.used));
    lay_out();
  }
  OwnedState(const OwnedState& other) : size(other.size), memory_(other.memory_) { lay_out(); }
  FilterSizes size;
  FilterState at;

 private:
  void lay_out() {
    Memory memory{memory_.data()};
    at = state_in(size, memory);
  }
  std::vector<double> memory_;
};

using SharedState = std::shared_ptr<OwnedState>;

SensorNoise make_noise(const Array& noise_) {
  const auto noise = input<1>("noise", noise_, {11});
  const double* const n = noise.data();
  return {n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], n[9], n[10] != 0.0};
}

std::vector<int> whole_numbers(const char* name, const In<1>& given, double below) {
  std::vector<int> numbers;
  for (std::ptrdiff_t k = 0; k < given.size(0); ++k) {
    const double number = given.data()[k];
    if (!(number >= 0 && number < below))
      throw nb::value_error((std::string(name) + ": an index is out of range").c_str());
    numbers.push_back(static_cast<int>(number));
  }
  return numbers;
}

int put_axes(const char* name, const Array& given_, int* axes) {
  const std::vector<int> given = whole_numbers(name, input<1>(name, given_, {ANY}), 3);
  if (given.empty() || given.size() > 3)
    throw nb::value_error((std::string(name) + ": give one to three axes").c_str());
  std::copy(given.begin(), given.end(), axes);
  return static_cast<int>(given.size());
}

OwnedFilter make_filter(const OwnedRobot& robot, const OwnedMinimalSets& sets,
                        const Array& theta_of_, const Array& pi_of_beta_,
                        const Array& pi_of_products_, const Array& pairs_, int sigmas,
                        const Array& momentum_axes, const Array& velocity_axes,
                        const Array& noise) {
  const int pis = sets.view().pis();
  const std::int64_t thetas = PER_BODY * robot.tree.view().bodies();
  const auto theta_of = input<2>("theta_of", theta_of_, {thetas, ANY});
  const std::int64_t betas = theta_of.size(1);
  if (sigmas != sets.view().phis() || betas < 1 + sigmas)
    throw nb::value_error("sigmas is not the number of first moments in beta");
  const int iotas = static_cast<int>(betas) - 1 - sigmas;
  const auto pi_of_beta = input<2>("pi_of_beta", pi_of_beta_, {pis, betas});
  const auto pairs = input<1>("pairs", pairs_, {ANY});
  const auto pi_of_products = input<2>("pi_of_products", pi_of_products_, {pis, pairs.size(0) / 2});
  for (int r = 0; r < pis; ++r)
    for (int c = 0; c < iotas; ++c)
      if (pi_of_beta.data()[r * betas + 1 + sigmas + c] != (r == c ? 1.0 : 0.0))
        throw nb::value_error("pi_of_beta: every iota must have one of the first pi for itself");
  OwnedFilter filter{robot, sets, sparse(theta_of), sparse(pi_of_beta), sparse(pi_of_products),
                     whole_numbers("pairs", pairs, sigmas), {}, make_noise(noise), pis, sigmas,
                     iotas};
  // The columns of M and sigma alone.
  filter.pi_of_shown.first.resize(static_cast<std::size_t>(sigmas) + 2);
  filter.axes.momenta = put_axes("momentum_axes", momentum_axes, filter.axes.momentum);
  filter.axes.velocities = put_axes("velocity_axes", velocity_axes, filter.axes.velocity);
  return filter;
}

using Numbers = In<1>;

SharedState start_of(const OwnedFilter& filter, const Array& beta_, const Array& root_,
                     const Array& sample_, std::optional<Array> h_cm_) {
  const FilterModel model = filter.view();
  const FilterSizes size = model.sizes();
  const auto beta = input<1>("beta", beta_, {size.betas()});
  const auto root = input<2>("root", root_, {size.betas(), size.betas()});
  const auto sample = input<1>("sample", sample_, {filter.measured()});
  std::optional<Numbers> h_cm;
  if (h_cm_) h_cm = input<1>("h_cm", *h_cm_, {3});
  auto state = std::make_shared<OwnedState>(size);
  Room room(model);
  start(model, beta.data(), root.data(), sample.data(), h_cm ? h_cm->data() : nullptr, state->at,
        room.at);
  return state;
}

SharedState opened(const OwnedFilter& filter, const OwnedState& before, const Array& beta_,
                   const Array& root_) {
  const FilterModel model = filter.view();
  const FilterSizes size = model.sizes();
  const auto beta = input<1>("beta", beta_, {size.betas()});
  const auto root = input<2>("root", root_, {size.betas(), size.betas()});
  auto state = std::make_shared<OwnedState>(size);
  Room room(model);
  const Matrix R_WB =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(before.at.R_WB);
  begin(model, *before.at.t, R_WB, beta.data(), root.data(), before.at.x, state->at, room.at);
  return state;
}

auto step_of(const OwnedFilter& filter, const OwnedState& before, double t, const Array& sample_) {
  const FilterModel model = filter.view();
  const auto sample = input<1>("sample", sample_, {filter.measured()});
  auto state = std::make_shared<OwnedState>(before);
  Room room(model);
  const Innovation innovation = step(model, state->at, t, sample.data(), room.at);
  Out<1> white(state->size.rows);
  for (int i = 0; i < state->size.rows; ++i)
    white.data()[i] = innovation.white[i * innovation.stride];
  return std::make_tuple(state, white.give(), innovation.nis, innovation.dof);
}

auto gathered(const OwnedFilter& filter, const OwnedState& before, const Array& t_,
              const Array& samples_) {
  const FilterModel model = filter.view();
  const auto t = input<1>("t", t_, {ANY});
  const auto samples = input<2>("samples", samples_, {t.size(0), filter.measured()});
  auto state = std::make_shared<OwnedState>(before);
  double squares = 0.0;
  std::ptrdiff_t rows = 0;
  {
    nb::gil_scoped_release release;
    Room room(model);
    for (std::ptrdiff_t k = 0; k < t.size(0); ++k) {
      const Innovation innovation = take_in(model, state->at, t.data()[k],
                                            samples.data() + k * filter.measured(), room.at);
      squares += innovation.nis;
      rows += innovation.dof;
    }
  }
  return std::make_tuple(state, squares, rows);
}

struct OwnedWatch {
  int rows, window;
  std::vector<double> sums, times;
  OwnedWatch(int rows, int window)
      : rows(rows),
        window(window),
        sums(static_cast<std::size_t>((window + 1) * rows)),
        times(static_cast<std::size_t>(window + 1)) {
    Watch watch = view();
    watch_nothing(watch);
  }
  Watch view() { return {rows, window, sums.data(), times.data()}; }
};

using SharedWatch = std::shared_ptr<OwnedWatch>;

SharedWatch make_watch(int rows, int window) {
  if (rows < 1 || window < 1) throw nb::value_error("rows, window: give at least one of each");
  return std::make_shared<OwnedWatch>(rows, window);
}

auto watched(const OwnedWatch& before, double t, const Array& white_) {
  const auto white = input<1>("white", white_, {before.rows});
  auto after = std::make_shared<OwnedWatch>(before);
  Watch watch = after->view();
  const Likelihood most = watch_one(watch, t, white.data(), 1);
  return std::make_tuple(after, most.g, most.onset);
}

// Steps until the samples end or g exceeds the threshold: the onset of that change, or none.
auto run(const OwnedFilter& filter, const OwnedState& before, const OwnedWatch& watch_before,
         double threshold, const Array& t_, const Array& samples_) {
  const FilterModel model = filter.view();
  const auto t = input<1>("t", t_, {ANY});
  const auto samples = input<2>("samples", samples_, {t.size(0), filter.measured()});
  auto state = std::make_shared<OwnedState>(before);
  auto after = std::make_shared<OwnedWatch>(watch_before);
  const int betas = state->size.betas();
  if (after->rows != state->size.rows)
    throw nb::value_error("watch: it has not the rows of the filter's innovations");
  Out<2> beta(t.size(0), betas), std(t.size(0), betas), tests(t.size(0), 3);
  std::ptrdiff_t done = 0;
  std::optional<double> onset;
  {
    nb::gil_scoped_release release;
    Room room(model);
    Watch watch = after->view();
    while (done < t.size(0) && !onset) {
      const double now = t.data()[done];
      const Innovation innovation =
          step(model, state->at, now, samples.data() + done * filter.measured(), room.at);
      const Likelihood most = watch_one(watch, now, innovation.white, innovation.stride);
      if (most.g > threshold) onset = most.onset;
      std::copy(state->at.beta, state->at.beta + betas, beta.data() + done * betas);
      deviations(model, state->at, room.at.beta, std.data() + done * betas);
      double* const test = tests.data() + 3 * done;
      test[0] = innovation.nis;
      test[1] = innovation.dof;
      test[2] = most.g;
      ++done;
    }
  }
  return std::make_tuple(state, after, done, onset, beta.give(), std.give(), tests.give());
}

auto vector(const double* from, int size) {
  Out<1> out(size);
  std::copy(from, from + size, out.data());
  return out.give();
}

// A table whose rows lie `stride` entries apart in the state.
auto table(const double* from, int rows, int columns, int stride) {
  Out<2> out(rows, columns);
  for (int i = 0; i < rows; ++i)
    std::copy(from + static_cast<std::ptrdiff_t>(i) * stride,
              from + static_cast<std::ptrdiff_t>(i) * stride + columns,
              out.data() + static_cast<std::ptrdiff_t>(i) * columns);
  return out.give();
}

// [iota, M, sigma | z] in the order of beta.
auto information(const FilterSizes& size, const double* from, bool with_z) {
  const int k = size.betas(), columns = with_z ? k + 1 : k;
  Out<2> out(k, columns);
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < columns; ++j) {
      const int own = j == k ? k : j < size.shown ? size.iotas + j : j - size.shown;
      out.data()[i * columns + j] = from[i * size.beta_stride() + own];
    }
  return out.give();
}

auto beta_of(const OwnedState& s) { return vector(s.at.beta, s.size.betas()); }
auto nuisances_of(const OwnedState& s) { return vector(s.at.x, s.size.nuisances); }
auto R_WB_of(const OwnedState& s) { return table(s.at.R_WB, 3, 3, 3); }
auto top_of(const OwnedState& s) {
  return table(s.at.top, s.size.nuisances, s.size.nuisances + s.size.parameters + 1,
               s.size.top_stride());
}
auto R_z_of(const OwnedState& s) {
  return table(s.at.R, s.size.parameters, s.size.parameters + 1, s.size.R_stride());
}
auto root_of(const OwnedState& s) { return information(s.size, s.at.root, false); }
auto prior_of(const OwnedState& s) { return information(s.size, s.at.prior, true); }

}  // namespace

void bind_recursive(nb::module_& m) {
  nb::class_<OwnedState>(m, "FilterState", "What the recursive filter carries; a constant.")
      .def_prop_ro("t", [](const OwnedState& s) { return *s.at.t; })
      .def_prop_ro("beta", &beta_of, nb::rv_policy::move)
      .def_prop_ro("nuisances", &nuisances_of, nb::rv_policy::move)
      .def_prop_ro("R_WB", &R_WB_of, nb::rv_policy::move)
      .def_prop_ro("top", &top_of, nb::rv_policy::move)
      .def_prop_ro("R_z", &R_z_of, nb::rv_policy::move)
      .def_prop_ro("root", &root_of, nb::rv_policy::move)
      .def_prop_ro("prior", &prior_of, nb::rv_policy::move);
  nb::class_<OwnedFilter>(m, "Filter", "The recursive filter of one robot and its sensors.")
      .def("__init__",
           [](OwnedFilter* self, const OwnedRobot& robot, const OwnedMinimalSets& sets,
              const Array& theta_of, const Array& pi_of_beta, const Array& pi_of_products,
              const Array& pairs, int sigmas, const Array& momentum_axes,
              const Array& velocity_axes, const Array& noise) {
             new (self) OwnedFilter(make_filter(robot, sets, theta_of, pi_of_beta, pi_of_products,
                                                pairs, sigmas, momentum_axes, velocity_axes,
                                                noise));
           },
           nb::arg("robot"), nb::arg("sets"), nb::arg("theta_of"), nb::arg("pi_of_beta"),
           nb::arg("pi_of_products"), nb::arg("pairs"), nb::arg("sigmas"),
           nb::arg("momentum_axes"), nb::arg("velocity_axes"), nb::arg("noise"))
      .def("start", &start_of, nb::arg("beta"), nb::arg("root"), nb::arg("sample"),
           nb::arg("h_cm").none())
      .def("opened", &opened, nb::arg("state"), nb::arg("beta"), nb::arg("root"))
      .def("step", &step_of, nb::arg("state"), nb::arg("t"), nb::arg("sample"))
      .def("gathered", &gathered, nb::arg("state"), nb::arg("t"), nb::arg("samples"))
      .def("run", &run, nb::arg("state"), nb::arg("watch"), nb::arg("threshold"), nb::arg("t"),
           nb::arg("samples"));
  nb::class_<OwnedWatch>(m, "Watch", "What a change detector remembers; a constant.")
      .def(nb::new_(&make_watch), nb::arg("rows"), nb::arg("window"))
      .def("step", &watched, nb::arg("t"), nb::arg("white"));
}

}  // namespace orbident::python
