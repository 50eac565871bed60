// The recursive filter made from checked tables.
#include "filter.hpp"

#include "arrays.hpp"

namespace orbident::python {
namespace {

int put_axes(const char* name, const Array& given_, int* axes) {
  const std::vector<int> given = whole_numbers(name, input<1>(name, given_, {ANY}), 3);
  if (given.empty() || given.size() > 3)
    throw nb::value_error((std::string(name) + ": give one to three axes").c_str());
  std::copy(given.begin(), given.end(), axes);
  return static_cast<int>(given.size());
}

}  // namespace

OwnedFilter make_filter(const OwnedRobot& robot, const OwnedMinimalSets& sets,
                        const Array& theta_of_, const Array& pi_of_beta_,
                        const Array& pi_of_products_, const Array& pairs_, int sigmas,
                        const Array& momentum_axes, const Array& velocity_axes,
                        const SensorNoise& noise, const Array& driven_, double longest) {
  const int pis = sets.view().pis();
  const std::int64_t thetas = PER_BODY * robot.tree.view().bodies();
  const auto theta_of = input<2>("theta_of", theta_of_, {thetas, ANY});
  const std::int64_t betas = theta_of.size(1);
  if (sets.tree.joints.size() != robot.tree.joints.size())
    throw nb::value_error("sets: they are of another robot");
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
  OwnedFilter filter{robot,
                     sets,
                     sparse(theta_of),
                     sparse(pi_of_beta),
                     sparse(pi_of_products),
                     whole_numbers("pairs", pairs, sigmas),
                     {},
                     noise,
                     {},
                     longest,
                     pis,
                     sigmas,
                     iotas};
  // The columns of M and sigma alone.
  filter.pi_of_shown.first.resize(static_cast<std::size_t>(sigmas) + 2);
  filter.axes.momenta = put_axes("momentum_axes", momentum_axes, filter.axes.momentum);
  // Of each [joint, walk, still, known, std].
  const auto driven = input<2>("driven", driven_, {ANY, 3 + 2 * DRIVES});
  const int joints = robot.tree.view().joints;
  for (std::ptrdiff_t k = 0; k < driven.size(0); ++k) {
    const double* const row = driven.data() + k * (3 + 2 * DRIVES);
    if (!(row[0] >= 0 && row[0] < joints)) throw nb::value_error("driven: there is no such joint");
    DrivenJoint joint{static_cast<int>(row[0]), row[1], row[2], {}, {}};
    std::copy(row + 3, row + 3 + DRIVES, joint.known);
    std::copy(row + 3 + DRIVES, row + 3 + 2 * DRIVES, joint.std);
    filter.driven.push_back(joint);
  }
  filter.axes.velocities = put_axes("velocity_axes", velocity_axes, filter.axes.velocity);
  return filter;
}

}  // namespace orbident::python
