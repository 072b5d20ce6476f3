// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem {

/// Quantile of the standard normal distribution.
double normal_quantile(double probability);
/// Quantile of the chi-squared distribution.
double chi_squared_quantile(double probability, double degrees_of_freedom);
/// Quantile of Student's t distribution.
double student_t_quantile(double probability, double degrees_of_freedom);

}  // namespace kalfem
