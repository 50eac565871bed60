// The extension module orbident._core: one bind_* function a subject.
#include <nanobind/nanobind.h>

namespace orbident::python {
void bind_dynamics(nanobind::module_& m);
void bind_householder(nanobind::module_& m);
void bind_output_error(nanobind::module_& m);
void bind_regressors(nanobind::module_& m);
}

NB_MODULE(_core, m) {
  m.doc() = "The numerical core: whole arrays in, whole arrays out, the GIL released inside.";
  // Python's caches keep robots until the process ends: that is no leak.
  nanobind::set_leak_warnings(false);
  orbident::python::bind_dynamics(m);
  orbident::python::bind_householder(m);
  orbident::python::bind_output_error(m);
  orbident::python::bind_regressors(m);
}
