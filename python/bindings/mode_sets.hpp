// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"
#include "kalfem/records/mode_set.hpp"

namespace kalfem::python {

/// The members of kalfem.ModeSet. Throws InvalidInput where they do not fit together.
ModeSet mode_set_of(const py::dict& given);

/// Those of kalfem.MeasuredModes, as comparing.py describes it.
MeasuredModes measured_modes_of(Structure& structure, const py::dict& given);
MeasuredResponses measured_responses_of(Structure& structure, const py::dict& given);

}  // namespace kalfem::python
