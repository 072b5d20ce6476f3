// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/units.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// What a run found.
struct IdentifiedValues {
  std::vector<double> unknowns;  ///< one per unknown of the filter, in the order of the case; empty: not estimated
  std::vector<double> updated;   ///< one per updated parameter, likewise
  /// Initial values of further unknowns, by name: those of the measurement and of the noise.
  std::vector<std::pair<std::string, double>> of_measurement;
  /// Numbers that are known to a deviation, where they were moved: of the structure; in words, of sensors and inputs.
  std::vector<std::pair<Parameter, double>> moved = {};
  std::vector<std::string> moved_signals = {};
};

/// A case file with identified values in it.
struct IdentifiedCase {
  std::string yaml;
  std::vector<std::string> notes;  ///< a sentence for each value that has no place among the substructures
};

/// The case of the study with each value in the place of its parameter: parameters of connectors, springs, masses,
/// damping, materials and regions. Initial values of unknowns and updated parameters become the values found, so that
/// a further run starts there; priors in per cent stay so, others stay as wide as they were in the filter's state. A
/// `chain` whose springs or masses are identified becomes `masses` and `springs`. Keys that the user's file does not
/// give are left out unless they changed. Files have absolute paths, numbers all their digits.
IdentifiedCase identified_case(const Study& study, const IdentifiedValues& values);

/// Writes a parameter's value into the description of a case that the structure was made from. Says whether the case
/// has a place for it.
bool put_value(description::Case& given, const StructureModel& structure, const Parameter& parameter, double value);

/// A number in SI with its unit; a bare one where the unit cannot be written.
Located<Quantity> value_in(double number, const std::string& unit);

}  // namespace kalfem
