// SPDX-License-Identifier: Apache-2.0
#include <regex>

#include "bindings.hpp"
#include "kalfem/base/atomic_file.hpp"

namespace kalfem::python {
namespace {

/// The words of a C++ program in those of Python: "unknowns[0] 'k'" is unknown['k'], "unknowns[0].std 'k'" its std,
/// Structure::points() a method.
std::string in_python(const std::string& text) {
  static const std::regex place(R"(^(sensors|unknowns|outputs|parameters)\[\d+\](\.\w+)? '([^']*)')");
  static const std::regex member(R"(\b(Structure|OnlineFilter|LiveFilter)::)");
  std::string words = std::regex_replace(text, place, "$1['$3']$2");
  if (words.starts_with("unknowns")) words.erase(7, 1);
  words = std::regex_replace(words, member, "$1.");
  static const std::regex online(R"(\b(an OnlineFilter|a LiveFilter)\b)"), filter(R"(\b(Online|Live)Filter\b)");
  words = std::regex_replace(words, online, "a Filter");
  return std::regex_replace(words, filter, "Filter");
}

/// Raises kalfem.InvalidInput with every issue.
void raise(const std::vector<Issue>& issues) {
  const py::module_ errors = py::module_::import("kalfem.errors");
  const py::object issue_type = errors.attr("Issue"), error_type = errors.attr("InvalidInput");
  py::list all;
  for (const auto& issue : issues)
    all.append(issue_type(in_python(issue.what), in_python(issue.why), in_python(issue.fix), issue.location.file,
                          issue.location.line));
  const py::object error = error_type(all);
  PyErr_SetObject(error_type.ptr(), error.ptr());
}

}  // namespace

std::string entry_of(const std::string& argument, const std::string& key) { return argument + "['" + key + "']"; }

Eigen::VectorXd vector_of(const py::handle& values, const std::string& argument) {
  const Column column = Column::ensure(values);
  if (!column) PyErr_Clear();
  if (!column || column.ndim() != 1)
    throw InvalidInput(
        argument + ": " + (column ? std::to_string(column.ndim()) + " dimensions" : "no array of numbers"),
        "one dimension of numbers is needed", "give a NumPy array of shape (n,)");
  return Eigen::Map<const Eigen::VectorXd>(column.data(), column.size());
}

void bind_errors(py::module_&) {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const WriteFailure& failure) {
      PyErr_SetString(PyExc_OSError, failure.what());
    } catch (const InvalidInput& error) {
      raise(error.issues());
    }
  });
}

}  // namespace kalfem::python
