// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "bindings.hpp"

namespace kalfem::python {

/// Results in the form of results.h5: path -> (array, attributes).
class Datasets {
public:
  template <class Values>
  void add(const std::string& path, Values values, const std::string& unit, std::optional<double> sample_rate = {}) {
    py::dict attributes;
    attributes["unit"] = unit;
    if (sample_rate) attributes["sample_rate"] = *sample_rate;
    all_[py::str(path)] = py::make_tuple(array_of(std::move(values)), attributes);
  }

  [[nodiscard]] py::dict take() { return std::move(all_); }

private:
  py::dict all_;
};

/// None for what is not known.
inline py::object number(double value) { return std::isfinite(value) ? py::object(py::float_(value)) : py::none(); }

/// As summary.json has it.
py::dict summary_of(const Verdict& verdict);

/// S from its lower triangles row by row, s (s + 1) / 2 x samples: an array samples x s x s.
py::array_t<double> covariances_of(const Eigen::MatrixXd& triangles, Eigen::Index sensors);

/// start + k / sample_rate, as results.h5 has it.
Eigen::VectorXd times_of(const Record& record);

}  // namespace kalfem::python
