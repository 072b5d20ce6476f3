// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/estimation/filter_kind.hpp"
#include "kalfem/estimation/gaussian.hpp"
#include "kalfem/estimation/outliers.hpp"
#include "kalfem/estimation/partially_linear/partially_linear_map.hpp"
#include "kalfem/estimation/unscented_transform.hpp"

namespace kalfem {

/// Why a filter could not go on.
enum class FilterOutcome {
  usable,
  model_not_evaluable,               ///< a connector force was not finite
  linear_part_impossible,            ///< an unknown of the linear part has a value that makes no structure
  covariance_not_positive_definite,  ///< the state's covariance lost its sign
  innovation_not_positive_definite   ///< the innovation's covariance did, or is singular: a sensor without noise
};

/// In words.
std::string to_string(FilterOutcome outcome);

/// Input of a filter. Everything here stays unchanged while the filter lives; the maps outlive the filter. The
/// owner of the maps sets their inputs (b, e and the moving columns of G) before each step.
struct FilterModel {
  PartiallyLinearMap& process;              ///< x <- process(x) + N(0, Q)
  Eigen::MatrixXd process_noise;            ///< Q, n x n
  PartiallyLinearMap& measurement;          ///< y = measurement(x) + N(0, R), every channel
  Eigen::MatrixXd measurement_noise;        ///< R, l x l
  PartiallyLinearMap* monitored = nullptr;  ///< further quantities for observe(), or none
};

/// y - A m - b and A P A^T + Omega + R of a measurement y = A x + b + e, e ~ N(0, Omega), under the prior m, P.
struct RelinearisedInnovation {
  Eigen::VectorXd value;       ///< l
  Eigen::MatrixXd covariance;  ///< l x l, lower triangle
};

/// The innovation of one measurement.
struct Innovation {
  std::vector<Eigen::Index> channels;  ///< the l channels that were measured, among all
  Eigen::VectorXd value;               ///< y - predicted y, l
  Eigen::MatrixXd covariance;          ///< P_yy + R, l x l, lower triangle
  double nis = 0.0;                    ///< normalised innovation squared, value^T covariance^-1 value
  double log_likelihood = 0.0;         ///< of this measurement given those before
  /// Whether an iterated update conditioned on `about_posterior`, the innovation of the measurement linearised there,
  /// in the place of `value` and `covariance`, which stay those of the prediction.
  bool relinearised = false;
  RelinearisedInnovation about_posterior = {};
  /// Variance that a robust update gave each channel in addition to R, within `covariance`; empty: none.
  Eigen::VectorXd added_variance = {};
  /// Channels that were measured and count less or not at all; `sample` is not set. Those left out do not stand above.
  std::vector<SetAsideSample> set_aside = {};

  /// With which the estimate was conditioned: x+ = x- + K conditioned_value().
  [[nodiscard]] const Eigen::VectorXd& conditioned_value() const {
    return relinearised ? about_posterior.value : value;
  }
  [[nodiscard]] const Eigen::MatrixXd& conditioned_covariance() const {
    return relinearised ? about_posterior.covariance : covariance;
  }
};

/// v <- L^-1 v for a few values, L lower triangular.
void whiten(const Eigen::MatrixXd& lower, Eigen::VectorXd& vector);

/// K = J L^-1 from J = P_xy L^-T, P_yy + R = L L^T.
Eigen::MatrixXd gain_from(const Eigen::MatrixXd& whitened_cross, const Eigen::MatrixXd& lower);

/// NIS and log-likelihood from the Cholesky factor L of the innovation's covariance and `whitened` = L^-1 value.
void score(Innovation& innovation, const Eigen::MatrixXd& factor, const Eigen::VectorXd& whitened);

/// A Gaussian filter over partially linear maps. Predict and update follow Table 1 with additive noise; sigma points
/// are drawn anew for each. An outcome other than usable leaves the estimate as it was. One thread.
class Filter {
public:
  /// The filter copies Q and R: a later change of the caller's matrices changes nothing.
  explicit Filter(FilterModel model);
  virtual ~Filter() = default;
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;

  virtual void reset(const Gaussian& estimate) = 0;
  /// x <- process(x) + N(0, Q), with the map's inputs as they are now.
  [[nodiscard]] virtual FilterOutcome predict() = 0;
  /// Conditions on y = measurement(x) + N(0, R). A value that is not a number is a channel that is missing; the others
  /// stand in `innovation.channels`. With none of them the estimate stays. Outliers are treated as treat_outliers()
  /// says, and channels of `held_out` are predicted, not learned from; both stand in `innovation.set_aside`.
  [[nodiscard]] FilterOutcome update(const Eigen::VectorXd& y, Innovation& innovation,
                                     const std::vector<Eigen::Index>& held_out = {});
  void treat_outliers(const OutlierOptions& options) { outliers_ = options; }
  /// Most passes of each update, see UnscentedOptions::update_iterations.
  void iterate_updates(int most) { update_iterations_ = most; }
  /// R from the next update on, l x l.
  void set_measurement_noise(const Eigen::MatrixXd& noise);
  /// Q from the next prediction on, n x n, at the cost of a copy; of its square root where the filter keeps one.
  virtual void set_process_noise(const Eigen::MatrixXd& noise) { model_.process_noise = noise; }
  /// Mean and, where asked for, standard deviation of the monitored quantities. Means are cheap, deviations may cost as
  /// much as a step.
  [[nodiscard]] virtual FilterOutcome observe(Eigen::VectorXd& mean, Eigen::VectorXd* deviation) = 0;
  /// Covariance of the monitored quantities with these states, quantities x states, by the last observe() that computed
  /// deviations.
  [[nodiscard]] virtual Eigen::MatrixXd monitored_with(const std::vector<Eigen::Index>& states) const = 0;

  /// Gain K of the last update, x+ = x- + K Innovation::conditioned_value(), n x measured channels [state/output]. It
  /// holds until the next prediction.
  [[nodiscard]] virtual Eigen::MatrixXd gain() const = 0;
  /// Its rows of these states alone, in their order.
  [[nodiscard]] virtual Eigen::MatrixXd gain_of(const std::vector<Eigen::Index>& states) const {
    return gain()(states, Eigen::all);
  }

  [[nodiscard]] virtual const Eigen::VectorXd& mean() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd standard_deviation() const = 0;
  [[nodiscard]] virtual Eigen::MatrixXd covariance() const = 0;
  /// Covariance of these states alone, in their order, at the cost of its size.
  [[nodiscard]] virtual Eigen::MatrixXd covariance_of(const std::vector<Eigen::Index>& states) const = 0;

protected:
  /// Value and covariance of the innovation of the measured channels, `innovation.channels`: `y` holds their values,
  /// `noise` is R of these alone. The estimate stays.
  virtual FilterOutcome expect(const Eigen::VectorXd& y, const Eigen::MatrixXd& noise, Innovation& innovation) = 0;
  /// Conditions on the innovation that the last expect() gave, with the same `noise`.
  virtual FilterOutcome correct(const Eigen::MatrixXd& noise, Innovation& innovation) = 0;

  [[nodiscard]] PartiallyLinearMap& process() const { return model_.process; }
  [[nodiscard]] PartiallyLinearMap& measurement() const { return model_.measurement; }
  [[nodiscard]] PartiallyLinearMap& monitored() const { return *model_.monitored; }
  [[nodiscard]] const Eigen::MatrixXd& process_noise() const { return model_.process_noise; }
  [[nodiscard]] int update_iterations() const { return update_iterations_; }
  [[nodiscard]] const Eigen::VectorXd& measured_values() const { return values_; }  ///< y of the last expect()
  [[nodiscard]] Eigen::Index channels() const { return model_.measurement_noise.rows(); }

private:
  void take_channels(const Eigen::VectorXd& y, const std::vector<Eigen::Index>& channels);
  bool screen(const std::vector<Eigen::Index>& held_out, Innovation& innovation);

  FilterModel model_;
  OutlierOptions outliers_;
  int update_iterations_ = 1;
  std::vector<Eigen::Index> noise_channels_;  ///< those that noise_ is of
  Eigen::MatrixXd noise_;
  Eigen::VectorXd values_, added_variance_;
};

/// A partially linear filter costs O(n^2) per step if the process model is block diagonal (StateCoordinates::modal),
/// otherwise it is a covariance filter with the same estimates. `threads` share its work on large covariances; results
/// do not depend on their number.
std::unique_ptr<Filter> make_filter(FilterKind kind, const FilterModel& model, const UnscentedOptions& options = {},
                                    int threads = 1);

}  // namespace kalfem
