// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.hpp"

namespace kalfem::python {

/// Even times.
struct TimeGrid {
  double start = 0.0, sample_rate = 0.0;
  Eigen::Index samples = 0;
};

/// The grid of an array of times [s]. Throws InvalidInput where they are uneven.
TimeGrid grid_of(const py::object& t);

/// The channels of these names as a record. `y`: a mapping (dictionary, DataFrame) of name to samples, or an array of
/// shape (samples, channels), or (samples,) of one channel. Throws InvalidInput with every channel that does not fit.
Record record_of(const TimeGrid& grid, const py::object& y, const std::vector<std::string>& names);

}  // namespace kalfem::python
