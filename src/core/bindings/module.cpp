// The extension module orbident._core: one bind_* function a subject.
#include <nanobind/nanobind.h>

namespace orbident::python {
void bind_dynamics(nanobind::module_& m);
void bind_regressors(nanobind::module_& m);
void bind_recursive(nanobind::module_& m);
}

NB_MODULE(_core, m) {
  // Tables are kept for the life of the process, which is no leak.
  nanobind::set_leak_warnings(false);
  m.doc() = "The numerical core: whole arrays in, whole arrays out, the GIL released inside.";
  orbident::python::bind_dynamics(m);
  orbident::python::bind_regressors(m);
  orbident::python::bind_recursive(m);
}
