// The robot's constant tables as Python holds them, and memory for one configuration.
#pragma once

#include <vector>

#include "arrays.hpp"
#include "orbident/forward_dynamics.hpp"
#include "orbident/lanes.hpp"
#include "orbident/regressors.hpp"

namespace orbident::python {

struct OwnedTree {
  std::vector<Joint> joints;
  Tree view() const { return {joints.data(), static_cast<int>(joints.size())}; }
};

struct OwnedRobot {
  OwnedTree tree;
  std::vector<double> theta, armature;
  std::vector<Wheel> wheels;
  Robot view() const {
    return {tree.view(), theta.data(), armature.data(), wheels.data(),
            static_cast<int>(wheels.size())};
  }
};

struct OwnedSparse {
  std::vector<int> first, row;
  std::vector<double> value;
  Sparse view() const {
    return {first.data(), row.data(), value.data(), static_cast<int>(first.size()) - 1};
  }
};

// Whole numbers that Python gives as float64, from zero to below a bound.
inline std::vector<int> whole_numbers(const char* name, const In<1>& given, double below) {
  std::vector<int> numbers;
  for (std::ptrdiff_t k = 0; k < given.size(0); ++k) {
    const double number = given.data()[k];
    if (!(number >= 0 && number < below))
      throw nb::value_error((std::string(name) + ": an index is out of range").c_str());
    numbers.push_back(static_cast<int>(number));
  }
  return numbers;
}

// The entries of a matrix that are not zero.
inline OwnedSparse sparse(const In<2>& dense) {
  OwnedSparse matrix;
  matrix.first.push_back(0);
  for (std::ptrdiff_t c = 0; c < dense.size(1); ++c) {
    for (std::ptrdiff_t r = 0; r < dense.size(0); ++r) {
      const double value = dense.data()[r * dense.size(1) + c];
      if (value == 0.0) continue;
      matrix.row.push_back(static_cast<int>(r));
      matrix.value.push_back(value);
    }
    matrix.first.push_back(static_cast<int>(matrix.row.size()));
  }
  return matrix;
}

struct OwnedMinimalSets {
  OwnedTree tree;
  OwnedSparse theta_of_linear, theta_of_sigma;
  std::vector<int> pairs;
  MinimalSets view() const {
    return {theta_of_linear.view(), theta_of_sigma.view(), pairs.data(),
            static_cast<int>(pairs.size() / 2)};
  }
};

// Memory for so many numbers.
template <class T>
std::vector<T> room(std::ptrdiff_t numbers) {
  return std::vector<T>(static_cast<std::size_t>(numbers));
}

template <class T>
class BodiesMemory {
 public:
  explicit BodiesMemory(const Tree& tree)
      : pose_(n(tree)), motions_(4 * n(tree)), mass_(2 * n(tree)), momentum_(n(tree)) {
    const std::size_t b = n(tree);
    at = {pose_.data(), motions_.data(),  motions_.data() + b, motions_.data() + 2 * b,
          mass_.data(), mass_.data() + b, momentum_.data()};
  }
  BodiesMemory(const BodiesMemory&) = delete;
  Bodies<T> at;

 private:
  static std::size_t n(const Tree& tree) { return static_cast<std::size_t>(tree.bodies()); }
  std::vector<Pose<T>> pose_;
  std::vector<Motion<T>> motions_;
  std::vector<Mass<T>> mass_;
  std::vector<Momentum<T>> momentum_;
};

// Three rows and their memory, zero at first.
template <class T>
struct OwnedRows {
  explicit OwnedRows(std::ptrdiff_t columns)
      : numbers(static_cast<std::size_t>(3 * columns), T(0.0)), view(numbers.data(), 3, columns) {}
  OwnedRows(const OwnedRows&) = delete;
  std::vector<T> numbers;
  Rows3<T> view;
};

// The bodies at many joint states and base rates.
class MovingBodies {
 public:
  MovingBodies(const Tree& tree, const In<2>& q, const In<2>& qd, const In<2>& w)
      : tree_(tree), q_(q), qd_(qd), w_(w), joints_(room<Lanes>(2 * tree.joints)), bodies_(tree) {}

  const Bodies<Lanes>& at(const Group& group) {
    Lanes *q = joints_.data(), *qd = q + tree_.joints;
    Vector3<Lanes> w;
    q_.load(group, q);
    qd_.load(group, qd);
    w_.load(group, w.data());
    place(tree_, q, bodies_.at.pose, bodies_.at.field);
    move(tree_, bodies_.at.field, w, qd, bodies_.at.motion);
    return bodies_.at;
  }

 private:
  Tree tree_;
  const In<2>&q_, &qd_, &w_;
  std::vector<Lanes> joints_;
  BodiesMemory<Lanes> bodies_;
};

template <class T>
class EquationsMemory {
 public:
  explicit EquationsMemory(const Robot& robot)
      : bodies_(robot.tree), values_(2 * n(robot) * (n(robot) + 1)) {
    T* H = values_.data();
    const std::size_t N = n(robot);
    eq = {bodies_.at, H, H + N * N, H + 2 * N * N, H + 2 * N * N + N, Vector3<T>::Zero()};
  }
  EquationsMemory(const EquationsMemory&) = delete;
  EquationsOfMotion<T> eq;

 private:
  static std::size_t n(const Robot& robot) { return static_cast<std::size_t>(robot.speeds()); }
  BodiesMemory<T> bodies_;
  std::vector<T> values_;
};

}  // namespace orbident::python
