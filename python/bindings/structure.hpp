// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"
#include "kalfem/api/structure_description.hpp"

namespace kalfem::python {

/// {"k": 1e4, "c": 20.0} in the order of the dictionary.
NamedValues values_of(const py::dict& values, const std::string& argument);

/// A law of the library by its name, a formula, or a function of Python.
Law law_of(const py::object& given, const NamedValues& values);

/// The structure with the samples that drive its inputs, which begin at `start` [s].
Structure driven(const Structure& structure, const py::dict& inputs, double start, double sample_rate,
                 Eigen::Index samples);

}  // namespace kalfem::python
