// Module gprodom._core: the Python bindings of the C++ library, one bind function per part.
#include <pybind11/pybind11.h>

void bind_gpr_filter(pybind11::module_& module);
void bind_gpr_peaks(pybind11::module_& module);
void bind_gpr_sfm(pybind11::module_& module);
void bind_gpr_revisit(pybind11::module_& module);
void bind_front_end(pybind11::module_& module);
void bind_outputs(pybind11::module_& module);
void bind_odometry(pybind11::module_& module);
void bind_map(pybind11::module_& module);

PYBIND11_MODULE(_core, module) {
  module.doc() = "Compiled parts of gprodom.";
  bind_gpr_filter(module);
  bind_gpr_peaks(module);
  bind_gpr_sfm(module);
  bind_gpr_revisit(module);
  bind_front_end(module);
  bind_outputs(module);
  bind_odometry(module);
  bind_map(module);
}
