// What a flight build needs to know of a filter: its constant tables, and how much memory it takes.
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "filter.hpp"
#include "orbident/flight_memory.hpp"

namespace orbident::python {
namespace {

template <class T>
auto numbers(const T* from, int count) {
  Out<1> out(count);
  for (int i = 0; i < count; ++i) out.data()[i] = static_cast<double>(from[i]);
  return out.give();
}

// Where columns begin, rows, values.
auto entries(const Sparse& table) {
  const int all = table.first[table.columns];
  return std::make_tuple(numbers(table.first, table.columns + 1), numbers(table.row, all),
                         numbers(table.value, all));
}

nb::dict tables_of(const OwnedFilter& filter) {
  const FilterModel model = filter.view();
  const MinimalSets& sets = model.laws.sets;
  nb::dict tables;
  tables["theta_of_linear"] = entries(sets.theta_of_linear);
  tables["theta_of_sigma"] = entries(sets.theta_of_sigma);
  tables["product"] = numbers(sets.pair, 2 * sets.products);
  tables["theta_of_beta"] = entries(model.laws.theta_of);
  tables["pi_of_shown"] = entries(model.sets.pi_of_shown);
  tables["pi_of_products"] = entries(model.sets.pi_of_products);
  tables["pair"] = numbers(model.sets.pair, 2 * model.sets.pi_of_products.columns);
  return tables;
}

auto memory_of(const OwnedFilter& filter, int window) {
  check_watch(filter.view().sizes().rows, window);
  const flight::Layout at = flight::layout(filter.view(), window, nullptr);
  return std::make_tuple(at.all, at.carried);
}

}  // namespace

void bind_flight(nb::module_& m) {
  m.def(
      "flight_tables", &tables_of, nb::arg("filter"),
      "Constant tables by name; a sparse one is where its columns begin, its rows and its values.");
  m.def("flight_memory", &memory_of, nb::arg("filter"), nb::arg("window"),
        "Numbers that a filter and its detector take, and those of them that are its state.");
}

}  // namespace orbident::python
