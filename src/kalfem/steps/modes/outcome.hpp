// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/steps/study_results.hpp"

namespace kalfem {

/// Undamped free vibration of one substructure as the case gives it.
struct SubstructureModes {
  std::string name;
  Eigen::Index dofs = 0;
  double mass = 0.0;            ///< with the fixed degrees of freedom [kg]
  Eigen::VectorXd frequencies;  ///< [Hz]; only the lowest of a finite-element model
  Eigen::MatrixXd shapes;       ///< dofs x modes, mass-normalised
};

/// The sizes of the substructures, and their modes where the run takes these.
struct ModesOutcome {
  std::vector<SubstructureModes> substructures;
  /// Of all parts together, where joints unite some [Hz], see joined_frequencies().
  Eigen::VectorXd joined_frequencies;
};

/// The substructures that an updating changed, at full order and the updated values: a step "update" leaves them.
struct UpdatedModes {
  std::vector<SubstructureModes> substructures;

  /// Nothing where the substructure was not updated.
  [[nodiscard]] const SubstructureModes* of(const std::string& substructure) const;
};

/// That of a run, empty where the run did not come so far.
const ModesOutcome& modes_found(const StudyResults& results);

/// The updated modes of a substructure; nothing where it was not updated, or the run does not take the modes.
const SubstructureModes* updated_modes_of(const StudyResults& results, const std::string& substructure);

}  // namespace kalfem
