// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"
#include "kalfem/steps/modes/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Modes of every substructure that has degrees of freedom: all of a lumped one, the lowest `count` of finite elements.
std::vector<SubstructureModes> substructure_modes(const Study& study, Eigen::Index count);
/// The same, of the substructures that the updating changes, at these values of its parameters.
UpdatedModes modes_at(const Study& study, const Eigen::VectorXd& values, Eigen::Index count);
/// The lowest `count` natural frequencies [Hz] of all parts together: superelements where they are reduced, connectors
/// linear about rest. Empty without joints; with a warning, where a connector has no tangent at rest.
Eigen::VectorXd joined_frequencies(const Study& study, Eigen::Index count, std::vector<std::string>& warnings);
/// These modes of a finite-element substructure at full order.
SubstructureModes modes_of(const FiniteElementPart& part, NormalModes modes);

}  // namespace kalfem
