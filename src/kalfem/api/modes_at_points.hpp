// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kalfem/api/update.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/updating/measured_mode.hpp"

namespace kalfem {

/// @name Points of a substructure
/// They throw InvalidInput for names that do not fit.
///@{
/// "frame.tip.z" as {"frame", "tip.z"}.
std::pair<std::string, std::string> split_point(const std::string& point);
/// A point of that substructure, without its name.
std::string point_in(const std::string& substructure, const std::string& point);
/// A degree of freedom or a named point of the model.
DofCombination combination_of(const LinearModel& model, const std::string& point);
///@}

/// Measured modes with the points of their shapes in the substructure.
struct ModesAtPoints {
  std::vector<MeasuredMode> modes;
  std::vector<DofCombination> points;
};
/// Throws InvalidInput with what does not fit.
ModesAtPoints modes_at_points(const MeasuredModes& given, const LinearModel& model);

}  // namespace kalfem
