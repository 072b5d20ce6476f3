// SPDX-License-Identifier: Apache-2.0
#include "bindings.hpp"
#include "kalfem/live/state_file.hpp"
#include "kalfem/study/live_plan.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/watch/watcher.hpp"

namespace kalfem::python {
namespace {

/// A live case that Python feeds. What it says and complains of is kept until it is taken.
class PythonWatch {
public:
  PythonWatch(const std::string& case_file, const std::vector<std::pair<std::string, std::optional<std::string>>>& set)
      : watcher_(
            [&] {
              const py::gil_scoped_release released;
              std::vector<CaseChange> changes;
              for (const auto& [key, value] : set) changes.push_back({key, value});
              return make_live_plan(load_study(case_file, changes));
            }(),
            [this](MessageKind, const std::string& line) { said_.push_back(line); },
            [this](const std::string& text) { complaints_.push_back(text); }) {}

  void take(const std::string& lines) {
    const py::gil_scoped_release released;
    for (std::size_t begin = 0; begin < lines.size();) {
      const std::size_t end = std::min(lines.find('\n', begin), lines.size());
      watcher_.take(std::string_view(lines).substr(begin, end - begin));
      begin = end + 1;
    }
  }
  void tell() { watcher_.tell(); }
  std::vector<std::string> take_said() { return std::exchange(said_, {}); }
  std::vector<std::string> take_complaints() { return std::exchange(complaints_, {}); }

  void write_state(const std::string& file) { write_state_file(file, watcher_.fingerprint(), watcher_); }
  void read_state(const std::string& file) { read_state_file(file, watcher_.fingerprint(), watcher_); }

private:
  std::vector<std::string> said_, complaints_;
  Watcher watcher_;
};

}  // namespace

void bind_watch(py::module_& module) {
  py::class_<PythonWatch>(module, "Watch")
      .def(py::init<const std::string&, const std::vector<std::pair<std::string, std::optional<std::string>>>&>())
      .def("_take", &PythonWatch::take)
      .def("_tell", &PythonWatch::tell)
      .def("_take_said", &PythonWatch::take_said)
      .def("_take_complaints", &PythonWatch::take_complaints)
      .def("_write_state", &PythonWatch::write_state)
      .def("_read_state", &PythonWatch::read_state);
}

}  // namespace kalfem::python
