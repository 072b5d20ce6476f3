// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"

namespace kalfem::python {

/// The options of an estimation from the arguments of Python, without the sensors. Throws InvalidInput with every
/// argument that does not fit, by its name.
EstimateOptions options_of(const Structure& structure, const py::dict& arguments);

}  // namespace kalfem::python
