// The scalar of constant tables and of the recursive filter: double, or float in a flight build.
//
// It is one for the whole program, and not a template's parameter: a flight computer has one
// filter, and Python's is always of double.
#pragma once

#include <limits>

#ifndef ORBIDENT_REAL
#define ORBIDENT_REAL double
#endif

namespace orbident {

using Real = ORBIDENT_REAL;

constexpr Real NOT_A_NUMBER = std::numeric_limits<Real>::quiet_NaN();

}  // namespace orbident
