// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the files of the compiled module share. Each file binds one stage of the public library.

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "kalfem/kalfem.hpp"

namespace kalfem::python {

namespace py = pybind11;

using Column = py::array_t<double, py::array::c_style | py::array::forcecast>;

void bind_analysis(py::module_& module);
void bind_command(py::module_& module);
void bind_errors(py::module_& module);
void bind_estimate(py::module_& module);
void bind_filter(py::module_& module);
void bind_watch(py::module_& module);
void bind_finite_elements(py::module_& module);
void bind_finished_runs(py::module_& module);
void bind_formats(py::module_& module);
void bind_infer(py::module_& module);
void bind_laws(py::module_& module);
void bind_likelihood(py::module_& module);
void bind_match(py::module_& module);
void bind_modal(py::module_& module);
void bind_mode_sets(py::module_& module);
void bind_run(py::module_& module);
void bind_sensors(py::module_& module);
void bind_simulate(py::module_& module);
void bind_statics(py::module_& module);
void bind_structure(py::module_& module);
void bind_sweep(py::module_& module);
void bind_place(py::module_& module);
void bind_update(py::module_& module);
void bind_validate(py::module_& module);
void bind_vibration(py::module_& module);

/// "sensors['a3']": an argument that is a dictionary, by its key.
std::string entry_of(const std::string& argument, const std::string& key);

/// The vector as an array that owns it, without a copy.
template <class Values>
py::object array_of(Values values) {
  return py::cast(std::move(values), py::return_value_policy::move);
}

/// One dimension of numbers. Throws InvalidInput, with the argument's name, where it has another shape or is no array
/// of numbers.
Eigen::VectorXd vector_of(const py::handle& values, const std::string& argument);

}  // namespace kalfem::python
