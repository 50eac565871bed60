// What a sample's neighbours expect: the median of cubics, each through four of them,
//
//   p_r(t_k) = sum_i x_i prod_{j != i} (t_k - t_j) / (t_i - t_j),   i, j in k + r {-2, -1, 1, 2},
//
// at the distances r = 1, 2, ... Near an end all four are on the inner side.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace orbident {

// The farthest distance that may be asked for, in samples.
constexpr int FARTHEST = 12;

// How many distances n samples have room for.
constexpr int distances(std::ptrdiff_t n, int farthest) {
  return static_cast<int>(std::min<std::ptrdiff_t>((n - 1) / 6, std::min(farthest, FARTHEST)));
}

// Lagrange's polynomial through the samples i, at the time t.
template <class T>
T cubic(const T* times, const T* x, const std::array<std::ptrdiff_t, 4>& i, T t) {
  T sum(0);
  for (std::size_t a = 0; a < 4; ++a) {
    T weight(1);
    for (std::size_t b = 0; b < 4; ++b)
      if (b != a) weight *= (t - times[i[b]]) / (times[i[a]] - times[i[b]]);
    sum += weight * x[i[a]];
  }
  return sum;
}

// Of sample k of n, by so many distances, one or more.
template <class T>
T expected(const T* t, const T* x, std::ptrdiff_t n, std::ptrdiff_t k, int count) {
  std::array<T, FARTHEST> found;
  for (int r = 1; r <= count; ++r) {
    std::array<std::ptrdiff_t, 4> i{k - 2 * r, k - r, k + r, k + 2 * r};
    if (i[3] >= n)
      i = {k - r, k - 2 * r, k - 3 * r, k - 4 * r};
    else if (i[0] < 0)
      i = {k + r, k + 2 * r, k + 3 * r, k + 4 * r};
    found[static_cast<std::size_t>(r - 1)] = cubic(t, x, i, t[k]);
  }
  const auto end = found.begin() + count;
  std::sort(found.begin(), end);
  const auto middle = static_cast<std::size_t>(count / 2);
  return count % 2 ? found[middle] : (found[middle - 1] + found[middle]) / T(2);
}

}  // namespace orbident
