// Arrays in and out: float64, C order, checked by name before anything is read.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

#include "memory.hpp"
#include "orbident/lanes.hpp"

namespace orbident::python {

namespace nb = nanobind;

using Array = nb::ndarray<nb::ro, nb::device::cpu>;
using DoublesIn = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

// A dimension of any size.
constexpr std::int64_t ANY = -1;

// A float64 array of the given shape. Its data stay alive as long as the view.
template <std::size_t N>
struct In {
  DoublesIn array;
  const double* data() const { return array.data(); }
  std::ptrdiff_t size(std::size_t axis) const {
    return static_cast<std::ptrdiff_t>(array.shape(axis));
  }
  // Some samples of it, which the first axis counts.
  void load(const Group& group, Lanes* x) const {
    std::ptrdiff_t numbers = 1;
    for (std::size_t axis = 1; axis < N; ++axis) numbers *= size(axis);
    group.load(data(), numbers, x);
  }
};

// Raises TypeError for another dtype and ValueError for another shape; both name the argument.
DoublesIn checked(const char* name, const Array& given, const std::int64_t* shape, std::size_t n);

template <std::size_t N>
In<N> input(const char* name, const Array& given, const std::array<std::int64_t, N>& shape) {
  return {checked(name, given, shape.data(), N)};
}

// run(group) for all samples from first to last - 1.
template <class Run>
void by_groups(std::ptrdiff_t first, std::ptrdiff_t last, Run&& run) {
  for (std::ptrdiff_t k = first; k < last; k += Lanes::COUNT) run(Group{k, last});
  end_writes_past_caches();
}

// What gives a block back when Python frees its array.
nb::capsule owner_of(const Block& block);

// A new float64 array that Python will own. Made and given under the GIL.
template <std::size_t N>
class Out {
 public:
  using Numpy = nb::ndarray<nb::numpy, double, nb::ndim<N>, nb::c_contig>;

  template <class... Sizes>
  explicit Out(Sizes... sizes) : shape_{static_cast<std::size_t>(sizes)...} {
    std::size_t size = 1;
    for (std::size_t each : shape_) size *= each;
    block_ = take_memory(size);
  }
  Out(Out&& other) noexcept : shape_(other.shape_), block_(other.block_) {
    other.block_.data = nullptr;
  }
  ~Out() {
    if (block_.data) give_memory_back(block_);
  }
  double* data() { return block_.data; }
  const std::array<std::size_t, N>& shape() const { return shape_; }

  // Some samples of it, which the first axis counts.
  void store(const Group& group, const Lanes* x) {
    std::size_t numbers = 1;
    for (std::size_t axis = 1; axis < N; ++axis) numbers *= shape_[axis];
    const auto each = static_cast<std::ptrdiff_t>(numbers);
    if (shape_[0] * numbers > PAST_CACHES)
      group.store(x, each, data(), WritePastCaches());
    else
      group.store(x, each, data(), Write());
  }

  // Hands the memory over.
  Numpy give() {
    double* data = block_.data;
    const nb::capsule owner = owner_of(block_);
    block_.data = nullptr;
    return Numpy(data, N, shape_.data(), owner);
  }

 private:
  std::array<std::size_t, N> shape_;
  Block block_;
};

}  // namespace orbident::python
