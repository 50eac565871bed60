// Cubic Hermite functions of [x_0, v_0, x_1, v_1] on 0 .. duration.
#pragma once

namespace orbident {

// Value, rate, acceleration.
struct Cubics {
  double value[4], rate[4], acceleration[4];
};

inline Cubics cubics(double time, double duration) {
  const double d = duration > 0.0 ? duration : 1.0;
  const double s = time / d, s2 = s * s, s3 = s2 * s;
  return {{1.0 - 3 * s2 + 2 * s3, d * (s - 2 * s2 + s3), 3 * s2 - 2 * s3, d * (s3 - s2)},
          {6 * (s2 - s) / d, 1.0 - 4 * s + 3 * s2, 6 * (s - s2) / d, 3 * s2 - 2 * s},
          {(12 * s - 6) / (d * d), (6 * s - 4) / d, (6 - 12 * s) / (d * d), (6 * s - 2) / d}};
}

}  // namespace orbident
