// SPDX-License-Identifier: Apache-2.0
#include "bindings.hpp"
#include "command_line.hpp"

namespace kalfem::python {
namespace {

int command(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const py::gil_scoped_release released;
  return command::command_line(static_cast<int>(words.size()), arguments.data());
}

}  // namespace

void bind_command(py::module_& module) {
  module.def("_command", &command, py::arg("words"),
             "The command kalfem in this process, which does nothing else: its exit code. For kalfem/command.py.");
}

}  // namespace kalfem::python
