// Memory for arrays that go to Python. A large block is new to the process page by page, which takes longer
// than to fill it: what Python has freed is kept for the next arrays. Both happen under the GIL.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "orbident/lanes.hpp"
#if defined(__x86_64__) || defined(_M_X64)
#include <emmintrin.h>
#endif

namespace orbident::python {

struct Block {
  double* data;
  std::size_t numbers;
};

class ArrayMemory {
 public:
  // A block of at least that many numbers.
  static Block take(std::size_t numbers) {
    std::vector<Block>& kept = blocks();
    for (std::size_t k = 0; k < kept.size(); ++k) {
      if (kept[k].numbers < numbers || kept[k].numbers > 2 * numbers) continue;
      const Block block = kept[k];
      kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(k));
      return block;
    }
    return {new double[numbers], numbers};
  }

  static void give_back(const Block& freed) noexcept {
    std::vector<Block>& kept = blocks();
    kept.push_back(freed);
    std::size_t all = 0;
    for (const Block& block : kept) all += block.numbers;
    while (all > MOST) {
      all -= kept.front().numbers;
      delete[] kept.front().data;
      kept.erase(kept.begin());
    }
  }

 private:
  // 64 MB: batches of some hundred samples of the largest regressors.
  static constexpr std::size_t MOST = 8'000'000;
  static std::vector<Block>& blocks() {
    static std::vector<Block>* kept = new std::vector<Block>;  // outlives every array
    return *kept;
  }
};

// Numbers of an array that no cache of one processor holds (8 MB). What is written there goes to memory
// at once, where the processor can do so: through the caches, every line would be read first.
constexpr std::size_t PAST_CACHES = 1'000'000;

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
