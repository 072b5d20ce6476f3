// SPDX-License-Identifier: Apache-2.0
#include "bindings.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/report/finished/comparison_report.hpp"

#include <nlohmann/json.hpp>

namespace kalfem::python {
namespace {

RunComparison compare(const std::vector<std::string>& folders, bool population) {
  const py::gil_scoped_release released;
  return compare_runs({folders.begin(), folders.end()}, population ? RunsAre::members : RunsAre::answers);
}

std::string summary_of(const RunComparison& comparison) {
  return comparison_json(comparison).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void write_page(const RunComparison& comparison, const std::string& path) {
  const py::gil_scoped_release released;
  write_file_atomically(path, render_html(comparison_page(comparison)));
}

}  // namespace

void bind_finished_runs(py::module_& module) {
  py::class_<RunComparison>(module, "RunComparison", "Finished runs side by side, see kalfem.compare_runs.")
      .def("__str__", &comparison_text)
      .def_readonly("warnings", &RunComparison::warnings)
      .def_property_readonly("summary", &summary_of, "What `kalfem compare --json` prints.")
      .def("write_page", &write_page, py::arg("path"));
  module.def("compare_runs", &compare, py::arg("folders"), py::arg("population"),
             "Read finished runs: see kalfem.compare_runs.");
}

}  // namespace kalfem::python
