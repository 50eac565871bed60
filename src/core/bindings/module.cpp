// The extension module orbident._core: one bind_* function a subject.
#include <nanobind/nanobind.h>

#include "memory.hpp"

namespace orbident::python {
void bind_attitude_fusion(nanobind::module_& m);
void bind_dynamics(nanobind::module_& m);
void bind_flight(nanobind::module_& m);
void bind_free_floating(nanobind::module_& m);
void bind_free_flying(nanobind::module_& m);
void bind_householder(nanobind::module_& m);
void bind_neighbours(nanobind::module_& m);
void bind_output_error(nanobind::module_& m);
void bind_excitation(nanobind::module_& m);
void bind_regressors(nanobind::module_& m);
void bind_recursive(nanobind::module_& m);
void bind_smoothing(nanobind::module_& m);
void bind_trajectories(nanobind::module_& m);
void bind_whitening(nanobind::module_& m);
}  // namespace orbident::python

NB_MODULE(_core, m) {
  // Python keeps robots in caches of modules, which it does not clear when it ends.
  nanobind::set_leak_warnings(false);
  m.doc() = "The numerical core: whole arrays in, whole arrays out, the GIL released inside.";
  m.def("give_back_memory", &orbident::python::empty_freed_blocks,
        "Give memory that is free, and that the process keeps, back to the system.");
  orbident::python::bind_attitude_fusion(m);
  orbident::python::bind_dynamics(m);
  orbident::python::bind_flight(m);
  orbident::python::bind_free_floating(m);
  orbident::python::bind_free_flying(m);
  orbident::python::bind_householder(m);
  orbident::python::bind_neighbours(m);
  orbident::python::bind_output_error(m);
  orbident::python::bind_excitation(m);
  orbident::python::bind_regressors(m);
  orbident::python::bind_recursive(m);
  orbident::python::bind_smoothing(m);
  orbident::python::bind_trajectories(m);
  orbident::python::bind_whitening(m);
}
