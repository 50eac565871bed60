// The rows of a block of samples are written by two threads; the nuisances, which lead from sample
// to sample, are taken from them by one. What is left is about the parameters alone and may be
// folded in any order: each half of a block into a triangle of its own, both of which become one at
// the end. So the sums are the same whatever the number of threads.
#include "gathering.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "orbident/parallel.hpp"

namespace orbident::python {
namespace {

constexpr std::ptrdiff_t HALVES = 2;

// Numbers in the rows of a block: with fewer, threads cost what they save; more leave the caches.
constexpr std::ptrdiff_t NUMBERS = 1 << 19;

class Gathering {
 public:
  Gathering(const OwnedFilter& filter, OwnedState& state, int threads)
      : model_(filter.view()),
        size_(state.size),
        state_(state.at),
        measured_(filter.measured()),
        threads_(threads),
        reduced_(held_in_beta(state.at)),
        parameters_(reduced_ ? size_.betas() : size_.parameters),
        stride_(size_.row_stride()),
        R_stride_(reduced_ ? size_.beta_stride() : size_.R_stride()),
        block_(std::max<std::ptrdiff_t>(NUMBERS / (size_.all_rows() * stride_), HALVES)),
        rooms_{Room(model_), Room(model_)},
        table_(static_cast<std::size_t>((block_ * size_.all_rows() + 1) * stride_)),
        other_(static_cast<std::size_t>(parameters_ * R_stride_)),
        equations_(static_cast<std::size_t>(block_)) {}

  Gathered all(const double* t, const double* samples, std::ptrdiff_t count) {
    for (std::ptrdiff_t first = 0; first < count; first += block_) {
      const std::ptrdiff_t n = std::min(block_, count - first);
      const double* const packed = samples + first * measured_;
      halves(n, [&](std::ptrdiff_t half, std::ptrdiff_t k) {
        equations_[static_cast<std::size_t>(k)] =
            equations_of(model_, state_, measurement(packed, k), rows(k), room(half));
      });
      for (std::ptrdiff_t k = 0; k < n; ++k)
        take_nuisances(t[first + k], measurement(packed, k), k);
      parallel_for(HALVES, threads_, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
        for (std::ptrdiff_t half = from; half < to; ++half) {
          const std::ptrdiff_t begin = n * half / HALVES, end = n * (half + 1) / HALVES;
          fold(triangle(half), R_stride_, rows(begin) + size_.nuisances, stride_,
               static_cast<int>(end - begin) * size_.all_rows(), R_stride_, parameters_);
        }
      }, 1);
      for (std::ptrdiff_t row = 0; row < n * size_.all_rows(); ++row)
        add(rows(0) + row * stride_ + size_.nuisances);
    }
    for (int first = 0; first < parameters_; first += BLOCK) {
      double* const from = other_.data() + first * R_stride_ + first;
      const int left = parameters_ - first, n = std::min(BLOCK, left);
      fold(triangle(0) + first * R_stride_ + first, R_stride_, from, R_stride_, n,
           R_stride_ - first, left);
      for (int row = 0; row < n; ++row) add(from + row * R_stride_ - first);
    }
    return found_;
  }

 private:
  FilterModel model_;
  FilterSizes size_;
  FilterState& state_;
  int measured_, threads_;
  bool reduced_;
  int parameters_, stride_, R_stride_;
  std::ptrdiff_t block_;
  std::array<Room, HALVES> rooms_;
  AlignedDoubles table_, other_;
  std::vector<SampleEquations> equations_;
  Gathered found_;

  FilterRoom& room(std::ptrdiff_t half) { return rooms_[static_cast<std::size_t>(half)].at; }
  double* rows(std::ptrdiff_t k) {
    return table_.data() + size_.row_start() + k * size_.all_rows() * stride_;
  }
  double* triangle(std::ptrdiff_t half) {
    return half ? other_.data() : reduced_ ? state_.root : state_.R;
  }
  Measurement measurement(const double* packed, std::ptrdiff_t k) const {
    return measurement_at(model_.laws.robot, packed + k * measured_);
  }

  // work(half, k) for the samples k of each half.
  template <class Work>
  void halves(std::ptrdiff_t n, const Work& work) {
    parallel_for(HALVES, threads_, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
      for (std::ptrdiff_t half = from; half < to; ++half)
        for (std::ptrdiff_t k = n * half / HALVES; k < n * (half + 1) / HALVES; ++k) work(half, k);
    }, 1);
  }

  void take_nuisances(double t, const Measurement& at, std::ptrdiff_t k) {
    if (counts(model_, state_, t, at) != Counts::yes) {
      std::fill_n(rows(k), size_.all_rows() * stride_, 0.0);
      return;
    }
    const SampleEquations& sample = equations_[static_cast<std::size_t>(k)];
    take_nuisances_in(model_, state_, t, at, sample, rows(k), room(0));
    found_.rows += sample.moving ? size_.rows : model_.laws.axes.momenta;
    for (int i = 0; i < size_.driven; ++i) found_.rows += std::isfinite(at.impulse[i]);
  }

  // What is left of a row of the parameters.
  void add(const double* row) { found_.squares += row[parameters_] * row[parameters_]; }
};

}  // namespace

Gathered gather(const OwnedFilter& filter, OwnedState& state, const double* t,
                const double* samples, std::ptrdiff_t count, int threads) {
  return Gathering(filter, state, threads).all(t, samples, count);
}

}  // namespace orbident::python
