// The recursive filter's constants, room and state as Python owns them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <vector>

#include "orbident/information_filter.hpp"
#include "robot.hpp"

namespace orbident::python {

// Begins where the widest vectors do: they are loaded faster from there.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t ALIGNMENT{LANES * sizeof(double)};
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), ALIGNMENT)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, ALIGNMENT); }
  bool operator==(const AlignedAllocator&) const { return true; }
  bool operator!=(const AlignedAllocator&) const { return false; }
};

using AlignedDoubles = std::vector<double, AlignedAllocator<double>>;

struct OwnedFilter {
  OwnedRobot robot;
  OwnedMinimalSets sets;
  OwnedSparse theta_of, pi_of_shown, pi_of_products;
  std::vector<int> pair;
  ConservedAxes axes;
  SensorNoise noise;
  std::vector<DrivenJoint> driven;
  double longest;
  int pis, sigmas, iotas;

  FilterModel view() const {
    return {{robot.view(),
             sets.view(),
             theta_of.view(),
             axes,
             noise,
             {driven.data(), static_cast<int>(driven.size()), longest}},
            {pi_of_shown.view(), pi_of_products.view(), pair.data(), pis, sigmas, iotas}};
  }
  int measured() const {
    return measurement_size(static_cast<int>(robot.tree.joints.size()),
                            static_cast<int>(robot.wheels.size()), static_cast<int>(driven.size()));
  }
};

// Room for steps, as long as a call takes.
class Room {
 public:
  explicit Room(const FilterModel& model) : bodies_(model.laws.robot.tree) {
    Memory count{nullptr};
    room_in(model, bodies_.at, count);
    doubles_.resize(static_cast<std::size_t>(count.used));
    Memory memory{doubles_.data()};
    at = room_in(model, bodies_.at, memory);
  }
  FilterRoom at;

 private:
  BodiesMemory<double> bodies_;
  AlignedDoubles doubles_;
};

// A state as Python holds it; never written to once it has been handed out.
class OwnedState {
 public:
  explicit OwnedState(const FilterSizes& size) : size(size) {
    Memory count{nullptr};
    state_in(size, count);
    memory_.resize(static_cast<std::size_t>(count.used));
    lay_out();
  }
  OwnedState(const OwnedState& other) : size(other.size), memory_(other.memory_) { lay_out(); }
  FilterSizes size;
  FilterState at;
  // All of it, to be kept and put back.
  const AlignedDoubles& numbers() const { return memory_; }
  void put(const double* numbers) { std::copy(numbers, numbers + memory_.size(), memory_.begin()); }

 private:
  void lay_out() {
    Memory memory{memory_.data()};
    at = state_in(size, memory);
  }
  AlignedDoubles memory_;
};

using SharedState = std::shared_ptr<OwnedState>;

// What a state is changed by must have its sizes.
inline void check_state(const FilterSizes& size, const OwnedState& state) {
  const FilterSizes& of = state.size;
  if (size.nuisances != of.nuisances || size.parameters != of.parameters ||
      size.shown != of.shown || size.iotas != of.iotas || size.rows != of.rows ||
      size.driven != of.driven)
    throw nb::value_error("state: it is of another filter");
}

// An int counts the sums of a detector.
inline void check_watch(int rows, int window) {
  if (rows < 1 || window < 1 || window >= std::numeric_limits<int>::max() / rows - LANES)
    throw nb::value_error(
        "rows, window: give at least one of each, and no more than there is room for");
}

OwnedFilter make_filter(const OwnedRobot& robot, const OwnedMinimalSets& sets,
                        const Array& theta_of, const Array& pi_of_beta, const Array& pi_of_products,
                        const Array& pairs, int sigmas, const Array& momentum_axes,
                        const Array& velocity_axes, const SensorNoise& noise, const Array& driven,
                        double longest);

// The parts of a state, as properties of a Python class.
void bind_filter_state(nb::module_& m);

}  // namespace orbident::python
