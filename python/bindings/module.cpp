// SPDX-License-Identifier: Apache-2.0
#include "bindings.hpp"
#include "kalfem/base/version.hpp"

namespace kalfem::python {

PYBIND11_MODULE(_core, module) {
  module.doc() = "The compiled part of kalfem: use the package kalfem.";
  module.attr("__version__") = version;
  bind_errors(module);
  bind_sensors(module);
  bind_laws(module);
  bind_finite_elements(module);
  bind_structure(module);
  bind_statics(module);
  bind_simulate(module);
  bind_estimate(module);
  bind_filter(module);
  bind_watch(module);
  bind_infer(module);
  bind_match(module);
  bind_modal(module);
  bind_mode_sets(module);
  bind_place(module);
  bind_update(module);
  bind_validate(module);
  bind_vibration(module);
  bind_formats(module);
  bind_likelihood(module);
  bind_run(module);
  bind_finished_runs(module);
  bind_analysis(module);
  bind_sweep(module);
  bind_command(module);
}

}  // namespace kalfem::python
