// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "kalfem/identification/fixed_numbers.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/updating/considered.hpp"

namespace kalfem {

/// The updated parameters, and behind them the numbers of the structure as further ones at their values. Gains are
/// none: ComparedGain.
UpdatingSetup with_numbers(UpdatingSetup updating, const std::vector<FixedNumber>& numbers);

/// Of the connectors among the bindings.
std::vector<StructureBinding> connectors_of(const std::vector<StructureBinding>& bindings);

/// What stated numbers add to an updating that ended at `values`, see consider(): first with the derivatives there,
/// then with those half way to the changes that the measurement asks for within what is stated, whose secant reaches
/// further than a tangent where responses are not linear in the numbers. `wide`: its comparisons as functions of
/// with_numbers(). Nothing where the model has no response.
std::optional<Considered> consider_stated(const std::vector<FixedNumber>& numbers,
                                          const std::vector<UpdatingParameter>& parameters,
                                          const Eigen::VectorXd& values, const ParameterStatistics& statistics,
                                          const ResidualValue& value, const std::vector<ResidualSum::Term>& wide);

}  // namespace kalfem
