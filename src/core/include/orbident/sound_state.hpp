// Whether numbers that were kept can be the state of a filter and its detector; their checksum.
//
// A state that was kept outside may be damaged, or no state at all. The filter trusts its own: a
// factor with a zero on its diagonal gives infinite numbers, and a count beyond its range an index
// beyond a table.
#pragma once

#include <cstdint>

#include "orbident/change_detection.hpp"
#include "orbident/hand_over.hpp"

namespace orbident {

inline bool is_finite(const Real* numbers, long count) {
  for (long i = 0; i < count; ++i)
    if (!std::isfinite(numbers[i])) return false;
  return true;
}

// Whether a factor's information is positive definite: no zero on its diagonal, and no overflow.
inline bool is_definite(const Real* factor, int stride, int rows) {
  for (int i = 0; i < rows; ++i) {
    const Real pivot = std::abs(factor[static_cast<long>(i) * stride + i]);
    if (!(pivot > 0 && std::isfinite(pivot))) return false;
  }
  return true;
}

// What every step is to leave behind.
inline bool is_estimate(const FilterState& state, const FilterSizes& size) {
  return is_finite(state.beta, size.betas()) && is_finite(state.x, size.nuisances) &&
         is_definite(state.root, size.beta_stride(), size.betas()) &&
         is_definite(state.top, size.top_stride(), size.nuisances);
}

// Whether `points` is a count of hand_over.hpp. A robot without joints is never held in beta, which
// is longer than y there: its tables have no room for that.
inline bool is_count(Real points, const FilterSizes& size) {
  const int most = size.betas() > size.parameters ? 0 : LINEAR_POINTS;
  return points >= 0 && points <= static_cast<Real>(most) &&
         static_cast<Real>(static_cast<int>(points)) == points;
}

// All numbers from R_WB on lie one after the other, with zeros between them. Times, rates and
// torques that were not yet are NaN.
inline bool is_sound(const FilterState& state, const FilterSizes& size) {
  const Real* const end = state.prior + static_cast<long>(size.betas()) * size.beta_stride();
  bool known = !std::isinf(*state.t);
  for (int i = 0; i < 3; ++i) known = known && !std::isinf(state.w[i]);
  for (int i = 0; i < size.driven; ++i) known = known && !std::isinf(state.impulse[i]);
  return known && is_finite(state.R_WB, end - state.R_WB) && is_count(*state.linear, size) &&
         is_estimate(state, size) && is_definite(state.prior, size.beta_stride(), size.betas());
}

// Times grow from the first that is known to the last one, which is t or before it.
inline bool is_sound(const Watch& watch, Real t) {
  Real before = NOT_A_NUMBER;
  for (int k = 0; k < watch.window; ++k) {
    const Real now = watch.times[k];
    if (std::isnan(now) ? !std::isnan(before) : std::isinf(now) || now <= before) return false;
    before = now;
  }
  return (std::isnan(before) || before <= t) && std::isnan(watch.times[watch.window]) &&
         is_finite(watch.sums, static_cast<long>(watch.window + 1) * watch.rows);
}

// CRC-32 of IEEE 802.3, as zlib's, of the numbers' bytes; in two halves, which a float can hold.
inline void checksum(const Real* numbers, long count, Real* halves) {
  const auto* const byte = reinterpret_cast<const unsigned char*>(numbers);
  std::uint32_t crc = 0xffffffffu;
  for (long i = 0; i < count * static_cast<long>(sizeof(Real)); ++i) {
    crc ^= byte[i];
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1u ? 0xedb88320u : 0u);
  }
  halves[0] = static_cast<Real>(~crc >> 16);
  halves[1] = static_cast<Real>(~crc & 0xffffu);
}

}  // namespace orbident
