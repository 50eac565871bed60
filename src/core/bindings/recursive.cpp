// The recursive filter and its change detector: one sample, or a whole recording.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include <optional>

#include "arrays.hpp"
#include "filter.hpp"
#include "gathering.hpp"
#include "orbident/opening.hpp"
#include "orbident/sound_state.hpp"

namespace orbident::python {
namespace {

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

SharedState opened(const OwnedFilter& filter, const OwnedState& before, const Array& change_,
                   std::optional<double> t) {
  const FilterModel model = filter.view();
  const FilterSizes size = model.sizes();
  const auto change = input<2>("change", change_, {size.betas(), size.betas()});
  check_state(size, before);
  auto state = std::make_shared<OwnedState>(before);
  Room room(model);
  AlignedDoubles tables(static_cast<std::size_t>(opening_numbers(size)));
  open_up(model, state->at, t ? *t : *before.at.t, change.data(), tables.data(), room.at);
  return state;
}

SharedState restored(const OwnedFilter& filter, const Array& numbers_) {
  auto state = std::make_shared<OwnedState>(filter.view().sizes());
  const auto numbers =
      input<1>("numbers", numbers_, {static_cast<std::int64_t>(state->numbers().size())});
  state->put(numbers.data());
  if (!is_sound(state->at, state->size))
    throw nb::value_error("numbers: they are no state of a filter of this robot");
  return state;
}

auto step_of(const OwnedFilter& filter, const OwnedState& before, double t, const Array& sample_) {
  const FilterModel model = filter.view();
  const auto sample = input<1>("sample", sample_, {filter.measured()});
  check_state(model.sizes(), before);
  auto state = std::make_shared<OwnedState>(before);
  Room room(model);
  const Innovation innovation = step(model, state->at, t, sample.data(), room.at);
  Out<1> white(state->size.rows);
  for (int i = 0; i < state->size.rows; ++i)
    white.data()[i] = innovation.white[i * innovation.stride];
  return std::make_tuple(state, white.give(), innovation.nis, innovation.dof);
}

auto gathered(const OwnedFilter& filter, const OwnedState& before, const Array& t_,
              const Array& samples_, int threads) {
  const auto t = input<1>("t", t_, {ANY});
  const auto samples = input<2>("samples", samples_, {t.size(0), filter.measured()});
  check_state(filter.view().sizes(), before);
  auto state = std::make_shared<OwnedState>(before);
  Gathered found;
  {
    nb::gil_scoped_release release;
    found = gather(filter, *state, t.data(), samples.data(), t.size(0), threads);
  }
  return std::make_tuple(state, found.squares, found.rows);
}

bool scaled_of(const OwnedFilter& filter, const OwnedState& state, double mass) {
  check_state(filter.view().sizes(), state);
  return scaled(filter.view(), state.at, mass);
}

struct OwnedWatch {
  int rows, window;
  std::vector<double> sums, times;
  std::vector<double> numbers() const {
    std::vector<double> all(sums);
    all.insert(all.end(), times.begin(), times.end());
    return all;
  }
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

auto given(const std::vector<double>& from) {
  Out<1> out(static_cast<std::ptrdiff_t>(from.size()));
  std::copy(from.begin(), from.end(), out.data());
  return out.give();
}

using SharedWatch = std::shared_ptr<OwnedWatch>;

SharedWatch make_watch(int rows, int window) {
  check_watch(rows, window);
  return std::make_shared<OwnedWatch>(rows, window);
}

SharedWatch watch_from(int rows, int window, const Array& numbers_) {
  const SharedWatch watch = make_watch(rows, window);
  const auto all = static_cast<std::int64_t>(watch->sums.size() + watch->times.size());
  const auto numbers = input<1>("numbers", numbers_, {all});
  const double* const times = numbers.data() + watch->sums.size();
  std::copy(numbers.data(), times, watch->sums.begin());
  std::copy(times, numbers.data() + all, watch->times.begin());
  if (!is_sound(watch->view(), times[window - 1]))
    throw nb::value_error("numbers: they are no state of a detector");
  return watch;
}

auto watched(const OwnedWatch& before, double t, const Array& white_) {
  const auto white = input<1>("white", white_, {before.rows});
  auto after = std::make_shared<OwnedWatch>(before);
  Watch watch = after->view();
  const Likelihood most = watch_one(watch, t, white.data(), 1);
  return std::make_tuple(after, most.g, most.onset);
}

// Steps until the samples end or g exceeds the threshold: the onset of that change, or none. Of
// each sample [nis, dof, g, whether it counts (0) or why not].
auto run(const OwnedFilter& filter, const OwnedState& before, const OwnedWatch& watch_before,
         double threshold, const Array& t_, const Array& samples_) {
  const FilterModel model = filter.view();
  const auto t = input<1>("t", t_, {ANY});
  const auto samples = input<2>("samples", samples_, {t.size(0), filter.measured()});
  check_state(model.sizes(), before);
  auto state = std::make_shared<OwnedState>(before);
  auto after = std::make_shared<OwnedWatch>(watch_before);
  const int betas = state->size.betas();
  if (after->rows != state->size.rows)
    throw nb::value_error("watch: it has not the rows of the filter's innovations");
  Out<2> beta(t.size(0), betas), std(t.size(0), betas), tests(t.size(0), 4);
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
      Likelihood most{0.0, now};
      if (innovation.counts == Counts::yes)
        most = watch_one(watch, now, innovation.white, innovation.stride);
      if (most.g > threshold) onset = most.onset;
      std::copy(state->at.beta, state->at.beta + betas, beta.data() + done * betas);
      deviations(model, state->at, room.at, std.data() + done * betas);
      double* const test = tests.data() + 4 * done;
      test[0] = innovation.nis;
      test[1] = innovation.dof;
      test[2] = most.g;
      test[3] = static_cast<double>(innovation.counts);
      ++done;
    }
  }
  return std::make_tuple(state, after, done, onset, beta.give(), std.give(), tests.give());
}

}  // namespace

void bind_recursive(nb::module_& m) {
  bind_filter_state(m);
  nb::class_<SensorNoise>(m, "SensorNoise", "Standard deviations, as the filter takes them.")
      .def(nb::init<Real, Real, Real, Real, Real, Real, Real, Real, Real, Real, Real, bool>(),
           nb::kw_only(), nb::arg("gyro"), nb::arg("velocity"), nb::arg("gyro_bias"),
           nb::arg("gyro_walk"), nb::arg("integrated"), nb::arg("attitude"),
           nb::arg("velocity_walk"), nb::arg("accelerometer_bias"), nb::arg("accelerometer_walk"),
           nb::arg("joint_rates"), nb::arg("momentum_walk"), nb::arg("accelerometer"));
  nb::class_<OwnedFilter>(m, "Filter", "The recursive filter of one robot and its sensors.")
      .def(nb::new_(&make_filter), nb::kw_only(), nb::arg("robot"), nb::arg("sets"),
           nb::arg("theta_of"), nb::arg("pi_of_beta"), nb::arg("pi_of_products"), nb::arg("pairs"),
           nb::arg("sigmas"), nb::arg("momentum_axes"), nb::arg("velocity_axes"), nb::arg("noise"),
           nb::arg("driven"), nb::arg("longest"))
      .def("start", &start_of, nb::arg("beta"), nb::arg("root"), nb::arg("sample"),
           nb::arg("h_cm").none())
      .def("opened", &opened, nb::arg("state"), nb::arg("change"), nb::arg("t") = nb::none())
      .def("restored", &restored, nb::arg("numbers"))
      .def("step", &step_of, nb::arg("state"), nb::arg("t"), nb::arg("sample"))
      .def("gathered", &gathered, nb::arg("state"), nb::arg("t"), nb::arg("samples"),
           nb::arg("threads") = 1)
      .def("scaled", &scaled_of, nb::arg("state"), nb::arg("mass"))
      .def("run", &run, nb::arg("state"), nb::arg("watch"), nb::arg("threshold"), nb::arg("t"),
           nb::arg("samples"));
  nb::class_<OwnedWatch>(m, "Watch", "What a change detector remembers; a constant.")
      .def(nb::new_(&make_watch), nb::arg("rows"), nb::arg("window"))
      .def_static("restored", &watch_from, nb::arg("rows"), nb::arg("window"), nb::arg("numbers"))
      .def_prop_ro("numbers", [](const OwnedWatch& watch) { return given(watch.numbers()); },
                   nb::rv_policy::move)
      .def("step", &watched, nb::arg("t"), nb::arg("white"));
}

}  // namespace orbident::python
