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
/// e_k = (r_k - phi r_k-1) / sqrt(1 - phi^2), ln p = sum_k ln N(e_k; 0, s^2) - (N - 1)/2 ln(1 - phi^2). Missing samples
/// (NaN) lengthen the step: phi^gap. -infinity where nothing was measured.
double log_density_of_correlated_series(const Eigen::Ref<const Eigen::VectorXd>& series, double interval,
                                        const CorrelatedError& error);

/// The likelihood of a record by open-loop simulation with correlated model error, one error model a channel.
class SimulationLikelihood {
public:
  /// `residual`: of series, time runs along the columns of its layout; `interval` of its samples [s]. Throws
  /// InvalidInput where there is not one error a channel, or one is negative.
  SimulationLikelihood(std::shared_ptr<const Residual> residual, std::vector<CorrelatedError> errors, double interval);
  /// -infinity where the simulation fails.
  [[nodiscard]] double log_likelihood(const Eigen::VectorXd& theta) const;

private:
  std::shared_ptr<const Residual> residual_;
  std::vector<CorrelatedError> errors_;
  double interval_;
};

}  // namespace kalfem
