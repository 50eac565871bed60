// Forward through many steps, and back through what each of them left behind.
//
// What is known is remembered only where a block starts, and each block's forward pass is done
// again on the way back: what the steps of a long record leave behind needs no memory.
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

#include "orbident/householder.hpp"

namespace orbident {

// Steps between two places where the state is remembered.
constexpr std::ptrdiff_t STEPS_A_BLOCK = 1024;

// forward(k, state) moves the state and returns what it leaves behind, for k = 0 .. steps - 1;
// turn(state) sees the last state; back(k, left) follows for k = steps - 1 .. 0.
template <class State, class Forward, class Turn, class Back>
ORBIDENT_INLINE void forward_and_back(std::ptrdiff_t steps, State state, Forward&& forward,
                                      Turn&& turn, Back&& back) {
  std::vector<State> starts;
  for (std::ptrdiff_t k = 0; k < steps; ++k) {
    if (k % STEPS_A_BLOCK == 0) starts.push_back(state);
    forward(k, state);
  }
  turn(state);
  std::vector<std::decay_t<decltype(forward(steps, state))>> left;
  left.reserve(static_cast<std::size_t>(STEPS_A_BLOCK));
  for (std::ptrdiff_t end = steps; !starts.empty(); starts.pop_back()) {
    const std::ptrdiff_t start = STEPS_A_BLOCK * static_cast<std::ptrdiff_t>(starts.size() - 1);
    state = starts.back();
    for (std::ptrdiff_t k = start; k < end; ++k) left.push_back(forward(k, state));
    for (; end > start; left.pop_back()) back(--end, left.back());
  }
}

}  // namespace orbident
