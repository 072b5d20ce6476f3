// SPDX-License-Identifier: Apache-2.0
#include <atomic>

#include "calls.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/report/finished/sweep_report.hpp"

namespace kalfem::python {
namespace {

using Changes = std::vector<std::pair<std::string, std::optional<std::string>>>;
using Axes = std::vector<std::pair<std::string, std::vector<std::string>>>;

/// A sweep whose runs may be made on several threads, and stopped from another one.
class StoppableSweep {
public:
  explicit StoppableSweep(SweepPlan plan) : sweep_(std::move(plan)) {}

  [[nodiscard]] const CaseSweep& get() const { return sweep_; }
  void stop() { stopped_ = true; }

  /// The line of a run, which takes one core: others are made beside it.
  std::string run_one(std::size_t number) {
    return LongCall(py::none()).run([&](const Progress&) {
      const auto* asked = StopScope::question();
      const StopQuestion question = [&] { return stopped_ || (asked && (*asked)()); };
      const StopScope scope(&question);
      const OneCore one_core;
      try {
        return to_line(sweep_.run_one(number));
      } catch (const Interrupted&) {
        if (stopped_) throw std::runtime_error("the sweep was stopped");
        throw;
      }
    });
  }

private:
  CaseSweep sweep_;
  std::atomic<bool> stopped_ = false;
};

std::unique_ptr<StoppableSweep> make_sweep(const std::string& case_file, const Changes& set, const Axes& axes,
                                           int seeds) {
  SweepPlan plan{.case_file = case_file, .seeds = seeds};
  for (const auto& [key, value] : set) plan.changes.push_back({key, value});
  for (const auto& [key, values] : axes) plan.axes.push_back({key, values});
  const py::gil_scoped_release released;
  return std::make_unique<StoppableSweep>(std::move(plan));
}

/// Lines that were made by to_line().
std::vector<SweepRun> runs_of(const std::vector<std::string>& lines) {
  std::vector<SweepRun> runs;
  for (const auto& line : lines) {
    auto run = sweep_run_of(line);
    if (!run) throw InvalidInput("a worker sent no run of a sweep: '" + line.substr(0, 80) + "'", "", "");
    runs.push_back(std::move(*run));
  }
  return runs;
}

/// What sweep.h5 holds: path -> (values, unit).
py::dict arrays_of(const StoppableSweep& self, const std::vector<std::string>& lines) {
  auto [texts, numbers] = sweep_arrays(self.get().plan(), finished_runs(runs_of(lines)));
  py::dict arrays;
  for (auto& [path, values] : texts) arrays[py::str(path)] = py::make_tuple(values, "");
  for (auto& [path, values, unit] : numbers) arrays[py::str(path)] = py::make_tuple(array_of(std::move(values)), unit);
  return arrays;
}

std::vector<std::pair<std::size_t, std::string>> known_runs(const SweepFolder& self) {
  std::vector<std::pair<std::size_t, std::string>> known;
  for (const auto& run : self.known()) known.emplace_back(run.number, to_line(run));
  return known;
}

}  // namespace

void bind_sweep(py::module_& module) {
  py::class_<StoppableSweep>(module, "Sweep", "A sweep that is ready to run.")
      .def(py::init(&make_sweep), py::arg("case"), py::arg("set"), py::arg("axes"), py::arg("seeds"))
      .def_property_readonly("identity", [](const StoppableSweep& self) { return self.get().identity(); })
      .def("__len__", [](const StoppableSweep& self) { return self.get().plan().size(); })
      .def("run_one", &StoppableSweep::run_one, py::arg("number"), "A run as a line of runs.jsonl.")
      .def("stop", &StoppableSweep::stop, "Ends the runs that are being made.")
      .def("arrays", &arrays_of, py::arg("lines"), "What sweep.h5 holds: path -> (values, unit).");
  py::class_<SweepFolder>(module, "SweepFolder", "The files of a sweep.")
      .def(py::init([](const std::string& folder, const StoppableSweep& sweep) {
             return std::make_unique<SweepFolder>(folder, sweep.get());
           }),
           py::arg("folder"), py::arg("sweep"))
      .def_property_readonly("known", &known_runs, "Numbers and lines of the runs of an earlier sweep.")
      .def(
          "add", [](SweepFolder& self, const std::string& line) { self.add(runs_of({line}).front()); }, py::arg("line"))
      .def(
          "finish",
          [](SweepFolder& self, const std::vector<std::string>& lines) { self.finish(finished_runs(runs_of(lines))); },
          py::arg("lines"));
}

}  // namespace kalfem::python
