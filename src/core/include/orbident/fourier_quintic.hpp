// Joint motions after Eq. 41, and their derivatives: sums over the functions
//
//   cos(w_f l t), sin(w_f l t), l = 1 .. N_f,   and   s^j, j = 0 .. 5,
//
// with s = t / t_f and w_f = 2 pi / t_f.
#pragma once

#include <cmath>

namespace orbident {

constexpr int QUINTIC = 6;

// The functions at s, 2 N_f + 6 of them, each from the one before.
template <class T>
void fourier_quintic(const T& s, int harmonics, T* function) {
  using std::cos;
  using std::sin;
  const T angle = T(2.0 * 3.14159265358979323846) * s, c = cos(angle), d = sin(angle);
  T *cosine = function, *sine = function + harmonics, *power = function + 2 * harmonics;
  for (int l = 0; l < harmonics; ++l) {
    cosine[l] = l == 0 ? c : cosine[l - 1] * c - sine[l - 1] * d;
    sine[l] = l == 0 ? d : cosine[l - 1] * d + sine[l - 1] * c;
  }
  power[0] = T(1);
  for (int j = 1; j < QUINTIC; ++j) power[j] = power[j - 1] * s;
}

}  // namespace orbident
