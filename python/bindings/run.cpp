// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/report/run_case.hpp"
#include "results.hpp"

namespace kalfem::python {
namespace {

CaseRun run(const std::string& case_file, const std::vector<std::pair<std::string, std::optional<std::string>>>& set,
            const std::string& folder, const std::string& last_step, const py::object& progress) {
  RunCaseOptions options{.folder = folder, .set = set, .last_step = last_step};
  return LongCall(progress).run([&](const Progress& report) {
    options.progress = report;
    return CaseRun(case_file, options);
  });
}

/// Draws of chains, one after the other, as chains x draws.
Eigen::MatrixXd by_chain(const Eigen::VectorXd& values, Eigen::Index chains) {
  return values.reshaped(values.size() / chains, chains).transpose();
}

py::dict datasets_of(const CaseRun& self) {
  Datasets data;
  self.visit([&](const CaseSeries& series) {
    if (series.chains)
      data.add(series.path, by_chain(series.values, *series.chains), series.unit);
    else
      data.add(series.path, series.values, series.unit, series.sample_rate);
  });
  for (auto& score : self.scores()) data.add("/innovation/scores/" + score.name, std::move(score.value), "");
  py::dict all = data.take();
  if (const auto& [triangles, sensors] = self.innovation_covariance(); triangles.size() > 0)
    all["/innovation/covariance"] = py::make_tuple(covariances_of(triangles, sensors), py::dict());
  return all;
}

}  // namespace

void bind_run(py::module_& module) {
  py::class_<CaseRun>(module, "CaseRun", "A run of a case with all its results.")
      .def_property_readonly("summary", &CaseRun::summary, "The text of summary.json.")
      .def_property_readonly("files", [](const CaseRun& self) { return self.result().files; })
      .def("datasets", &datasets_of, "What results.h5 holds: path -> (array, attributes).")
      .def(
          "write_report",
          [](const CaseRun& self, const std::string& path) {
            const py::gil_scoped_release released;
            write_file_atomically(path, self.report());
          },
          py::arg("path"), "Write report.html.");
  module.def("run_case", &run, py::arg("case"), py::arg("set"), py::arg("folder"), py::arg("last_step"),
             py::arg("progress") = py::none(), "Run a case file in this process: see kalfem.run.");
}

}  // namespace kalfem::python
