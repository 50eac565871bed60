// Memory for arrays that go to Python. A large block is new to the process page by page, which
// takes longer than to fill it: what Python has freed is kept for the next arrays. Both happen
// under the GIL (arrays.cpp).
#pragma once

#include <cstddef>
#include <cstring>

#include "orbident/lanes.hpp"
#if defined(__x86_64__) || defined(_M_X64)
#include <emmintrin.h>
#endif

namespace orbident::python {

struct Block {
  double* data;
  std::size_t numbers;
};

// A block of at least that many numbers, and its return.
Block take_memory(std::size_t numbers);
void give_memory_back(const Block& freed) noexcept;

// Numbers of an array that no cache of one processor holds (8 MB). What is written there goes to
// memory at once, where the processor can do so: through the caches, every line would be read
// first.
constexpr std::size_t PAST_CACHES = 1'000'000;

// Frees what is kept, and gives all free memory back to the system where it can be.
void empty_freed_blocks() noexcept;

struct WritePastCaches {
  void operator()(double* to, double value) const {
#if defined(__x86_64__) || defined(_M_X64)
    long long bits;
    std::memcpy(&bits, &value, sizeof bits);
    _mm_stream_si64(reinterpret_cast<long long*>(to), bits);
#else
    *to = value;
#endif
  }
  // Begins at a multiple of its own size.
  void operator()(double* to, const Lanes::Numbers& values) const {
#if defined(__x86_64__) || defined(_M_X64)
    static_assert(Lanes::COUNT == 2);
    _mm_stream_pd(to, _mm_set_pd(values[1], values[0]));
#else
    Eigen::Map<Lanes::Numbers> place(to);
    place = values;
#endif
  }
};

struct Write {
  void operator()(double* to, double value) const { *to = value; }
  void operator()(double* to, const Lanes::Numbers& values) const {
    Eigen::Map<Lanes::Numbers> place(to);
    place = values;
  }
};

// After this, other threads see what was written so.
inline void end_writes_past_caches() {
#if defined(__x86_64__) || defined(_M_X64)
  _mm_sfence();
#endif
}

}  // namespace orbident::python
