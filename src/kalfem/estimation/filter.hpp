#pragma once

#include <memory>
#include <string>

#include "kalfem/estimation/gaussian.hpp"
#include "kalfem/estimation/innovation.hpp"
#include "kalfem/estimation/partially_linear/partially_linear_map.hpp"
#include "kalfem/estimation/unscented_transform.hpp"

namespace kalfem {

enum class FilterKind {
  unscented,              ///< Table 1 of the paper, covariance form
  unscented_square_root,  ///< the same estimates, the covariance carried as a triangular factor
  partially_linear,       ///< sigma points of the few nonlinear channels only, O(n^2) a step in modal coordinates
  partially_linear_square_root,  ///< the same estimates, the covariance carried as a triangular factor
  extended                       ///< first-order linearisation about the mean
};

/// As case files and summaries say it.
std::string name_of(FilterKind kind);

/// Why a filter could not go on.
enum class FilterOutcome {
  usable,
  model_not_evaluable,               ///< a connector force was not finite or its solve did not converge
  linear_part_impossible,            ///< an unknown of the linear part has a value that makes no structure
  covariance_not_positive_definite,  ///< the state's covariance lost its sign
  innovation_not_positive_definite   ///< the innovation's covariance did, or is singular: a sensor without noise
};

/// In words, with what to do.
std::string to_string(FilterOutcome outcome);

/// A Gaussian filter over partially linear maps. Predict and update follow Table 1 with additive noise; sigma points
/// are drawn anew for each. An outcome other than usable leaves the estimate as it was. One thread.
class Filter {
public:
  virtual ~Filter() = default;

  virtual void reset(const Gaussian& estimate) = 0;
  /// x <- map(x) + N(0, Q).
  [[nodiscard]] virtual FilterOutcome predict(PartiallyLinearMap& transition, const Eigen::MatrixXd& process_noise) = 0;
  /// Conditions on y = map(x) + N(0, R).
  [[nodiscard]] virtual FilterOutcome update(PartiallyLinearMap& measurement, const Eigen::MatrixXd& noise,
                                             const Eigen::VectorXd& y, Innovation& innovation) = 0;
  /// Mean and, where asked for, standard deviation of another map of the present estimate. Means are cheap, deviations
  /// may cost as much as a step.
  [[nodiscard]] virtual FilterOutcome observe(PartiallyLinearMap& map, Eigen::VectorXd& mean,
                                              Eigen::VectorXd* deviation) = 0;

  [[nodiscard]] virtual const Eigen::VectorXd& mean() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd standard_deviation() const = 0;
  [[nodiscard]] virtual Eigen::MatrixXd covariance() const = 0;
};

/// A partially linear filter is one of O(n^2) where `transition`, the map of all its predictions, is given and block
/// diagonal (StateCoordinates::modal), else a covariance filter with the same estimates. `threads` share its work on
/// large covariances; results do not depend on their number.
std::unique_ptr<Filter> make_filter(FilterKind kind, const UnscentedOptions& options = {},
                                    const PartiallyLinearMap* transition = nullptr, int threads = 1);

}  // namespace kalfem
