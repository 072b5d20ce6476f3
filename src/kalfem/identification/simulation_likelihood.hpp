#pragma once

#include <memory>
#include <optional>

#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// The error of a simulated channel: exponentially correlated, r_k = phi r_k-1 + e_k, phi = exp(-dt /
/// correlation_time).
struct CorrelatedError {
  double correlation_time = 0.0;  ///< [s]; 0: independent samples
  std::optional<double> deviation =
      {};  ///< stationary, in those of the residual; empty: profiled, its most likely value
};

/// ln p of a series whose error is a stationary Gaussian process of first order, in O(samples): with e_1 = r_1 and
/// e_k = (r_k - phi r_k-1) / sqrt(1 - phi^2),
///     ln p = sum_k ln N(e_k; 0, s^2) - (N - 1)/2 ln(1 - phi^2).
/// Missing samples (NaN) lengthen the step: phi^gap. Of a profiled deviation, s^2 = sum_k e_k^2 / N: then infinity for
/// a series of zeros. -infinity where nothing was measured or a value is infinite. `interval` of the samples [s].
/// Throws InvalidInput where the interval is not positive, the correlation time negative, or the deviation not
/// positive.
double log_density_of_correlated_series(const Eigen::Ref<const Eigen::VectorXd>& series, double interval,
                                        const CorrelatedError& error);

/// The likelihood of a record by open-loop simulation with correlated model error, one error model a channel:
/// ln p(r(theta)), of the residual in its own units.
class SimulationLikelihood {
public:
  /// `residual`: of series (layout_of_series()), `interval` of its samples [s]. Rows that compare nothing are missing
  /// samples. Throws InvalidInput where there is not one error a channel, or one is not as
  /// log_density_of_correlated_series() needs it.
  SimulationLikelihood(std::shared_ptr<const Residual> residual, std::vector<CorrelatedError> errors, double interval);
  /// -infinity where the simulation fails.
  [[nodiscard]] double log_likelihood(const Eigen::VectorXd& theta) const;

private:
  std::shared_ptr<const Residual> residual_;
  std::vector<CorrelatedError> errors_;
  double interval_;
  std::vector<std::vector<Eigen::Index>> rows_;  ///< of each channel, along time
  std::vector<bool> compared_;                   ///< by row
};

}  // namespace kalfem
