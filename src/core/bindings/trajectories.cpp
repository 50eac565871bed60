// Joint motions after Eq. 41 at many times.
#include "arrays.hpp"
#include "orbident/fourier_quintic.hpp"
#include "orbident/no_heap.hpp"
#include "orbident/parallel.hpp"
#include "robot.hpp"

namespace orbident::python {
namespace {

auto fourier_quintic_at(const Array& coefficients_, const Array& s_, int threads) {
  const auto coefficients = input<3>("coefficients", coefficients_, {ANY, ANY, ANY});
  const auto s = input<1>("s", s_, {ANY});
  const std::ptrdiff_t n = s.size(0), orders = coefficients.size(0), K = coefficients.size(1),
                       m = coefficients.size(2);
  if (m < QUINTIC || m % 2 != 0)
    throw nb::value_error("coefficients: the last axis is not that of 2 N_f + 6 functions");
  const int harmonics = static_cast<int>(m - QUINTIC) / 2;
  Out<3> values(orders, n, K);
  {
    nb::gil_scoped_release release;
    parallel_for(n, threads, [&](std::ptrdiff_t first, std::ptrdiff_t last) {
      std::vector<Lanes> function = room<Lanes>(m), sums = room<Lanes>(K);
      const NoHeap guard;
      by_groups(first, last, [&](const Group& group) {
        Lanes s_k;
        s.load(group, &s_k);
        fourier_quintic(s_k, harmonics, function.data());
        const double* coefficient = coefficients.data();
        for (std::ptrdiff_t order = 0; order < orders; ++order) {
          for (Lanes& sum : sums) {
            sum = Lanes(0.0);
            for (const Lanes& each : function) sum += Lanes(*coefficient++) * each;
          }
          group.store(sums.data(), K, values.data() + order * n * K, Write());
        }
      });
    });
  }
  return values.give();
}

}  // namespace

void bind_trajectories(nb::module_& m) {
  m.def("fourier_quintic", &fourier_quintic_at, nb::arg("coefficients"), nb::arg("s"),
        nb::arg("threads") = 1,
        "Positions and derivatives (orders x times x joints) after Eq. 41 at the parts s of the "
        "duration, from their coefficients (orders x joints x functions).");
}

}  // namespace orbident::python
