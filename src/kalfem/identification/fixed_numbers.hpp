// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/known_to.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// What a number is, in the groups by which KnownTo names them.
enum class FixedNumberKind { mass, stiffness, damping, position, law, gain, excitation, delay, drift };

/// "masses", "stiffnesses", "damping", "positions", "laws", "gains", "excitations", "delays", "drifts".
std::string group_of(FixedNumberKind kind);

/// A number of an estimation that is held fixed: of the structure, the gain or clock of a sensor, or gain and delay of
/// an excitation. A change of it is counted in its `scale`.
struct FixedNumber {
  std::string name;
  std::string unit = {};
  double value = 0.0;
  double scale = 0.0;  ///< |value|; of a delay 1 s, of a drift 1 s/s; of a number that is 0 its stated deviation
  FixedNumberKind kind = FixedNumberKind::law;
  std::optional<Parameter> parameter = {};  ///< of the structure
  bool of_sensor = false;                   ///< a gain, delay or drift of a sensor
  double deviation = 0.0;                   ///< stated by KnownTo [scale]; 0: taken as exact

  [[nodiscard]] bool is_delay() const { return kind == FixedNumberKind::delay; }
  [[nodiscard]] bool is_drift() const { return kind == FixedNumberKind::drift; }
  [[nodiscard]] bool is_of_clock() const { return is_delay() || is_drift(); }
};

/// Whether a name of KnownTo fits the number: its own, that of its owner or part, or its group.
bool is_named(const FixedNumber& number, const std::string& name);

/// The parameters of a structure with their values in these parts, but for those in `estimated`.
std::vector<Parameter> fixed_parameters(const StructureModel& structure, const StructureParts& parts,
                                        const std::set<std::string>& estimated);

/// The names of parameters that the filter estimates, and of those that an updating found.
std::set<std::string> estimated_parameters(const EstimationSettings& settings, const std::vector<std::string>& updated);

/// Every number that an estimation holds fixed, in the order of the structure, then of the sensors and excitations of
/// `setup`. `updated`: parameters that an updating found.
std::vector<FixedNumber> held_numbers(const EstimationProblem& problem, const StructureParts& parts,
                                      const AugmentedModelSetup& setup, const std::vector<std::string>& updated);

/// Those that are not zero, or stated by the settings' known_to, with what is stated.
std::vector<FixedNumber> fixed_numbers(const EstimationProblem& problem, const StructureParts& parts,
                                       const AugmentedModelSetup& setup, const std::vector<std::string>& updated);

/// Those of `all` of which something is stated, with it.
std::vector<FixedNumber> stated_numbers(std::vector<FixedNumber> all, const std::vector<KnownTo>& known_to);

/// Mistakes of what is stated of fixed numbers, which go to `issues`: a name that no number has, an unknown, a
/// deviation that is not above 0 or a relative one above 100 %, a relative one of numbers that are 0 or of a clock.
/// `estimated`: names of numbers that are not fixed.
void check_known_to(const std::vector<KnownTo>& known_to, const std::vector<FixedNumber>& all,
                    const std::set<std::string>& estimated, IssueList& issues);
/// The same of an estimation's.
void check_known_to(const EstimationProblem& problem, const StructureParts& parts, const AugmentedModelSetup& setup,
                    IssueList& issues);

/// Numbers that an updating holds fixed: parameters of the structure but those that it refines, and the gains of what
/// it compares. Those of connectors count where a record of the whole structure is compared.
std::vector<FixedNumber> held_in_updating(const StructureModel& structure, const std::set<std::string>& refined,
                                          const std::vector<ComparedGain>& gains, bool with_connectors);

}  // namespace kalfem
