// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/innovation_window.hpp"
#include "kalfem/api/online_filter.hpp"
#include "kalfem/estimation/failure.hpp"
#include "kalfem/estimation/filter_setup.hpp"

namespace kalfem {

/// A filter with its model and present state, moved from sample to sample. move() sets the inputs of an interval and
/// predicts over it. update() conditions on the sensors and, once the unknowns of the linear part have moved far
/// enough, relinearises the model. After a stop both return false and change nothing.
class OnlineLoop {
public:
  /// `window`: samples over which its innovations are judged. Throws InvalidInput as OnlineFilter does.
  OnlineLoop(const Structure& structure, double sample_rate, const EstimateOptions& options, Eigen::Index window);

  /// The inputs at the present sample, [r; r'; r''] one after the other, 3 n_u.
  void set_inputs(Eigen::VectorXd inputs) { inputs_ = std::move(inputs); }
  [[nodiscard]] const Eigen::VectorXd& inputs() const { return inputs_; }

  /// To the next sample, with inputs that are linear up to it, 3 n_u.
  bool move_to(const Eigen::VectorXd& inputs);
  /// To the next sample, with the inputs at its instants, 3 n_u x (instants + 1).
  bool move_along(const Eigen::MatrixXd& inputs);
  bool update(const Eigen::VectorXd& measured);

  /// Mean and standard deviation of a motion or an output; throws InvalidInput where there is none of that name.
  [[nodiscard]] PresentEstimate observe(const std::string& name);
  [[nodiscard]] ParameterEstimate parameter(std::size_t i) const;
  [[nodiscard]] std::size_t unknowns() const { return model_->options().unknowns.size(); }
  [[nodiscard]] bool in_physical_coordinates() const;

  [[nodiscard]] Eigen::Index instants() const { return model_->options().instants(); }
  [[nodiscard]] double step() const { return step_; }  ///< from sample to sample [s]
  [[nodiscard]] long sample() const { return sample_; }
  [[nodiscard]] double time() const { return static_cast<double>(sample_) * step_; }
  [[nodiscard]] const std::optional<FilterStop>& failure() const { return failure_; }
  [[nodiscard]] const Eigen::VectorXd& innovation() const { return innovation_; }
  [[nodiscard]] double nis() const { return nis_; }
  [[nodiscard]] const InnovationWindow& window() const { return window_; }

private:
  template <class SetInputs>
  bool move(const SetInputs& set_inputs, const Eigen::VectorXd& next);
  /// Makes a step of the filter; where the covariance has lost its sign in modal coordinates, once more in physical
  /// ones. A step that fails leaves the estimate as it was.
  template <class Step>
  bool went_on(const Step& step);
  bool stop_unless_usable(FilterOutcome outcome);
  /// Carries the estimate over to a model in physical coordinates; false where it stands in these already or is not
  /// finite.
  bool use_physical_coordinates();
  /// Values and deviations of the unknowns of the linear part, now or by their prior.
  [[nodiscard]] LinearEstimate linear_estimate(bool prior) const;
  bool linearise_where_it_moved();

  std::vector<SensorDescription> sensors_;
  FilterProblem made_;
  double step_;  ///< [s]
  EstimationOptions options_;
  std::shared_ptr<const AugmentedModel> model_;  ///< at the start of the run
  std::unique_ptr<FilterSetup> setup_;
  std::vector<Eigen::Index> linear_unknowns_;
  LinearEstimate linearised_about_;
  Eigen::MatrixXd noise_;
  Eigen::VectorXd inputs_;  ///< at the present sample
  Eigen::VectorXd innovation_;
  double nis_;
  long sample_ = 0;
  std::optional<FilterStop> failure_;
  InnovationWindow window_;
};

}  // namespace kalfem
