// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// The weighted sum of the comparisons, unsmoothed.
ResidualSum last_sum(const std::vector<ComparisonResidual>& comparisons);

/// Root mean square of the values of a residual of `size` rows, cost = |r|^2 / 2.
double rms_of(double cost, Eigen::Index size);

/// Residual at the end of a search, with its Jacobian if it was computed; nothing where it is not at hand.
using LastResidual = std::optional<ResidualValue>;

/// Searches by the plan's method: CMA-ES, Gauss-Newton from several starts, or from one start with continuation and a
/// checkpoint in the options' folder. `first`: the residual at the initial values.
///
/// From one start the search may end between two modes that had to change places: where they come close, their shapes
/// mix, and no small step leads past that. So where the compared modes differ by more than noise at the end, a second
/// search begins where one ends that counts close modes as one group (ModalResidual::with_close_modes_joined()), and
/// the lower of both ends holds.
LastResidual search(const Study& study, const std::vector<ComparisonResidual>& comparisons, const ResidualValue& first,
                    const RunOptions& options, UpdatingOutcome& updating);

}  // namespace kalfem
