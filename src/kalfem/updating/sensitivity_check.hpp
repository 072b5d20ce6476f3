// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/updating/residual.hpp"

namespace kalfem {

struct SensitivityCheckOptions {
  double first_step = 1e-2;  ///< of the differences, in parts of scale_i
  int halvings = 5;          ///< of the step, each with two evaluations
  double tolerance = 1e-4;   ///< of the relative deviation
};

/// A column of the Jacobian against central differences.
struct SensitivityComparison {
  enum class Verdict {
    agrees,
    deviates,
    undecided,   ///< the differences themselves are less sure than the tolerance
    no_response  ///< the model has none beside the point
  };
  std::string parameter;
  double deviation = 0.0;    ///< max |J_i - differences| / max |differences|; the absolute one where these are zero
  double uncertainty = 0.0;  ///< estimated error of the differences, relative as above
  Eigen::Index row = 0;      ///< of the residual, where they deviate most
  Verdict verdict = Verdict::agrees;
};
[[nodiscard]] std::string explain(SensitivityComparison::Verdict verdict);

/// Why a search found no lower cost where it ended, from the comparisons there: a derivative that is wrong, a residual
/// that is not smooth, or neither. One clause, to follow explain(Termination::no_progress).
[[nodiscard]] std::string explain_stall(const std::vector<SensitivityComparison>& comparisons);

/// Compares the analytic Jacobian at `values` with central differences, extrapolated to step zero from steps halved in
/// turn; the extrapolation of least estimated error counts [Rid82]. Steps keep within the bounds; at a bound the inward
/// one-sided difference of second order serves. Parameters with equal bounds are left out. Empty where the model has no
/// response at `values`.
std::vector<SensitivityComparison> check_sensitivities(const Residual& residual,
                                                       const std::vector<UpdatingParameter>& parameters,
                                                       const Eigen::VectorXd& values,
                                                       const SensitivityCheckOptions& options = {});

}  // namespace kalfem
