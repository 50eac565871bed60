// The checks of arrays and the memory of those that go to Python, compiled once for all bindings.
#include "arrays.hpp"

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <new>
#include <string>
#include <vector>

namespace orbident::python {
namespace {

// 16 MB: batches of some hundred samples of large regressors.
constexpr std::size_t MOST = 2'000'000;

// Freed blocks, the oldest first.
std::vector<Block>& freed_blocks() {
  static std::vector<Block>* kept = new std::vector<Block>;  // outlives every array
  return *kept;
}

std::string in_words(const std::int64_t* shape, std::size_t n) {
  std::string words = "(";
  for (std::size_t k = 0; k < n; ++k)
    words += (k ? ", " : "") + (shape[k] == ANY ? std::string("any") : std::to_string(shape[k]));
  return words + (n == 1 ? ",)" : ")");
}

}  // namespace

DoublesIn checked(const char* name, const Array& given, const std::int64_t* shape, std::size_t n) {
  if (given.dtype() != nb::dtype<double>())
    throw nb::type_error((std::string(name) + " is not float64; give float64").c_str());
  bool right = given.ndim() == n;
  for (std::size_t k = 0; right && k < n; ++k)
    right = shape[k] == ANY || static_cast<std::int64_t>(given.shape(k)) == shape[k];
  if (!right) {
    std::array<std::int64_t, 8> found{};
    const std::size_t axes = std::min<std::size_t>(given.ndim(), found.size());
    for (std::size_t k = 0; k < axes; ++k) found[k] = static_cast<std::int64_t>(given.shape(k));
    throw nb::value_error((std::string(name) + " has the shape " + in_words(found.data(), axes) +
                           "; give " + in_words(shape, n))
                              .c_str());
  }
  DoublesIn array;
  // Another order is copied, and there may be no room for the copy.
  if (!nb::try_cast(nb::cast(given), array)) throw std::bad_alloc();
  return array;
}

Block take_memory(std::size_t numbers) {
  std::vector<Block>& kept = freed_blocks();
  for (std::size_t k = 0; k < kept.size(); ++k) {
    if (kept[k].numbers < numbers || kept[k].numbers > 2 * numbers) continue;
    const Block block = kept[k];
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(k));
    return block;
  }
  return {new double[numbers], numbers};
}

void give_memory_back(const Block& freed) noexcept {
  std::vector<Block>& kept = freed_blocks();
  kept.push_back(freed);
  std::size_t all = 0;
  for (const Block& block : kept) all += block.numbers;
  while (all > MOST) {
    all -= kept.front().numbers;
    delete[] kept.front().data;
    kept.erase(kept.begin());
  }
}

void empty_freed_blocks() noexcept {
  for (const Block& block : freed_blocks()) delete[] block.data;
  freed_blocks().clear();
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

nb::capsule owner_of(const Block& block) {
  return nb::capsule(new Block(block), [](void* p) noexcept {
    give_memory_back(*static_cast<Block*>(p));
    delete static_cast<Block*>(p);
  });
}

}  // namespace orbident::python
