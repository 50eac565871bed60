// Many samples taken in at once, all linearised about the same estimate.
#pragma once

#include <cstddef>

#include "filter.hpp"

namespace orbident::python {

struct Gathered {
  double squares = 0.0;     // of the residuals, which are of unit variance
  std::ptrdiff_t rows = 0;  // how many equations these are
};

// The state is that after the last sample, with the estimate and the nuisances' values of before.
Gathered gather(const OwnedFilter& filter, OwnedState& state, const double* t,
                const double* samples, std::ptrdiff_t count, int threads);

}  // namespace orbident::python
