#pragma once

#include <string>
#include <vector>

#include "kalfem/updating/parameter_statistics.hpp"

namespace kalfem {

/// Sentences for a reader on what the residual does not tell: parameters that it does not see or sees poorly,
/// combinations that cannot be told apart, pairs of high correlation, parameters at a bound, residuals larger than
/// their deviations. Empty where all is well.
std::vector<std::string> parameter_findings(const std::vector<UpdatingParameter>& parameters,
                                            const Eigen::VectorXd& values, const ParameterStatistics& statistics);

/// The parameters without equal bounds whose columns of the Jacobian are zero: the residual does not depend on them.
std::vector<std::string> without_effect(const std::vector<UpdatingParameter>& parameters,
                                        const Eigen::MatrixXd& jacobian);

}  // namespace kalfem
