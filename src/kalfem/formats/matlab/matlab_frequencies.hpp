// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of MATLAB files only.

#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>

#include "kalfem/formats/matlab/matlab_scope.hpp"

namespace kalfem {

/// Frequencies of a complex array, and where they come from.
struct FrequencyAxis {
  Eigen::VectorXd lines;                ///< [Hz]
  const MatlabValue* source = nullptr;  ///< the vector; null: a first frequency and a step
  std::string note;                     ///< how they were found, where the name alone does not say it
};

/// Whether a vector of this name beside complex numbers holds their frequencies: f, freq, frequency, f_hz.
bool is_exact_frequency_name(std::string_view name);

/// The same of less certain names too: Frequency_Hz, faxis, omega.
bool is_frequency_name(std::string_view name);

/// The frequencies of a complex array of these lengths. In this order: a vector with a name of frequencies (f, freq,
/// Frequency_Hz, faxis; w, omega: in rad/s); an axis that stands in a structure of its own; a step (df, delta_f,
/// increment) with a first frequency; the only vector of the structure that increases from 0 or more. It must be as
/// long as the first or the last dimension. Nothing where there is none.
std::optional<FrequencyAxis> frequencies_for(const std::vector<Eigen::Index>& lengths, const Scope& scope);

}  // namespace kalfem
