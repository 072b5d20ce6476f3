// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

struct FilterLikelihoodOptions {
  /// Values of the named unknowns at which substeps, the start and the prepared inputs are decided, in their own units;
  /// empty: the unknowns' initial values.
  std::optional<Eigen::VectorXd> first = {};
};

/// What a filter predicts of every sample before it sees it.
struct PredictedInnovations {
  Eigen::MatrixXd value;  ///< v_k, l x samples, NaN where missing [the channel's unit as recorded, also under a gain]
  /// S_k, its lower triangle row by row, l (l + 1) / 2 x samples, NaN where missing.
  Eigen::MatrixXd covariance;
};

/// The marginal likelihood of a record by a pass of the filter,
///     ln p(y_1..y_N | theta) = sum_k ln N(v_k; 0, S_k),
/// at given values theta of the named unknowns: states integrated out, process noise included. Named unknowns leave the
/// filter's state and are set in the structure; the others stay in the state and are integrated out under their priors.
/// Exact for linear systems, otherwise within the filter's approximation.
///
/// Substeps and the assumed start are decided once at the first values, and finite elements keep the bases of their
/// reduction there, so that the likelihood is one smooth function of theta. All const members may be called from
/// several threads at once.
///
/// The filter passes once over the record, with the noise and outliers as they are: every sample counts. Unknowns
/// without a state that are not named keep their initial values. A named sensor offset is taken off the record.
class FilterLikelihood {
public:
  /// `names`: of the problem's unknowns, those without a state (delays, gains, noise) and sensor offsets among them; in
  /// their own units. Throws InvalidInput where a name is unknown or doubled or its unknown drifts, where the problem
  /// asks for adaptive noise, or where the filter cannot be made at the first values.
  FilterLikelihood(const EstimationProblemPtr& problem, Record record, std::vector<std::string> names,
                   const FilterLikelihoodOptions& options = {});

  [[nodiscard]] const std::vector<std::string>& names() const;
  [[nodiscard]] const Eigen::VectorXd& first() const;  ///< values at which the constructor decided

  /// ln p(y_k | y_1..y_k-1, theta) of every sample, 0 where nothing was measured. Empty where theta is impossible or
  /// the filter fails.
  [[nodiscard]] std::optional<Eigen::VectorXd> log_densities(const Eigen::VectorXd& theta) const;
  /// Their sum; -infinity where there is none.
  [[nodiscard]] double log_likelihood(const Eigen::VectorXd& theta) const;
  /// v_k and S_k; empty as log_densities().
  [[nodiscard]] std::optional<PredictedInnovations> innovations(const Eigen::VectorXd& theta) const;

private:
  class Implementation;
  std::shared_ptr<const Implementation> implementation_;
};

}  // namespace kalfem
