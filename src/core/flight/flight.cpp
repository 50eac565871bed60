// The only C++ file: the filter of information_filter.hpp behind the interface of flight.h.

// One version of every function, of the compiler's own target, and the smaller one.
#define ORBIDENT_WIDEST
#define ORBIDENT_SMALL
// Eigen: no allocation, no checks that print, no file of another licence.
#ifndef NDEBUG
#define NDEBUG
#endif
#define EIGEN_NO_MALLOC
#define EIGEN_MPL2_ONLY

#include "orbident/flight.hpp"
#include "robot.h"

static_assert(orbident::flight::layout(ROBOT, nullptr).all <= ROBOT_MEMORY,
              "robot.h is of another version; export it again");
static_assert(orbident::flight::layout(ROBOT, nullptr).carried == ROBOT_STATE,
              "robot.h is of another version; export it again");
