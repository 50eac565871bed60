// Loops over samples on several threads. A sample's result never depends on which thread made it,
// so results are the same to the last bit whatever the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace orbident {

// Fewer samples than this are not worth a thread.
constexpr std::ptrdiff_t SAMPLES_A_THREAD = 128;

// run(first, last) for consecutive parts of 0 .. count; an exception of any part is thrown here.
template <class Run>
void parallel_for(std::ptrdiff_t count, int threads, Run&& run,
                  std::ptrdiff_t least = SAMPLES_A_THREAD) {
  const std::ptrdiff_t parts = std::clamp<std::ptrdiff_t>(count / least, 1, std::max(threads, 1));
  if (parts == 1) return run(std::ptrdiff_t(0), count);
  std::vector<std::exception_ptr> failed(static_cast<std::size_t>(parts));
  const auto part = [&](std::ptrdiff_t k) {
    try {
      run(count * k / parts, count * (k + 1) / parts);
    } catch (...) {
      failed[static_cast<std::size_t>(k)] = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  for (std::ptrdiff_t k = 1; k < parts; ++k) {
    try {
      others.emplace_back(part, k);
    } catch (const std::system_error&) {  // the system has no more threads
      part(k);
    }
  }
  part(0);
  for (std::thread& other : others) other.join();
  for (const std::exception_ptr& error : failed)
    if (error) std::rethrow_exception(error);
}

}  // namespace orbident
