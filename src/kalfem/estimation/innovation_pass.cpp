// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/innovation_pass.hpp"

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/estimation/filter_setup.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// One filter on its way. The model is relinearised where the unknowns of its linear part have moved, as in estimate().
class InnovationPass {
public:
  InnovationPass(const std::shared_ptr<const AugmentedModel>& augmented_model, const FilterInput& input,
                 const EstimationOptions& options)
      : first_(*augmented_model),
        input_(input),
        options_(options),
        setup_(std::make_unique<FilterSetup>(augmented_model, input.noise, options)),
        linear_unknowns_(linear_unknowns(augmented_model->options())),
        linearised_about_(linear_estimate(first_, linear_unknowns_, {})) {
    setup_->filter->reset(first_.prior());
    for (const Index place : linear_unknowns_) linear_states_.push_back(first_.layout().unknown() + place);
  }

  FilterOutcome run(const InnovationSink& keep) {
    for (Index k = 0; k < input_.measured.samples(); ++k) {
      stop_if_asked();
      if (const auto outcome = step(k); outcome != FilterOutcome::usable) return outcome;
      keep(k, innovation_);
    }
    return FilterOutcome::usable;
  }

private:
  FilterOutcome step(Index k) {
    FilterOutcome outcome = k == 0 ? FilterOutcome::usable : predict_to(k, input_, *setup_);
    if (outcome == FilterOutcome::usable)
      outcome = update_at(k, input_, options_.held_out, *setup_, measured_, innovation_);
    return outcome == FilterOutcome::usable && !linear_unknowns_.empty() ? relinearise_where_it_moved() : outcome;
  }

  FilterOutcome relinearise_where_it_moved() {
    const LinearEstimate now = present_estimate();
    if (!now.outdates(linearised_about_)) return FilterOutcome::usable;
    try {
      setup_ = relinearised(first_, now, *setup_, input_.noise, options_);
    } catch (const InvalidInput&) {
      return FilterOutcome::linear_part_impossible;
    }
    linearised_about_ = now;
    return FilterOutcome::usable;
  }

  /// Of the unknowns of the linear part, in their own units.
  [[nodiscard]] LinearEstimate present_estimate() const {
    const VectorXd mean = setup_->filter->mean()(linear_states_);
    const VectorXd variance = setup_->filter->covariance_of(linear_states_).diagonal();
    LinearEstimate now{VectorXd(mean.size()), VectorXd(mean.size())};
    for (Index i = 0; i < mean.size(); ++i) {
      const auto place = static_cast<std::size_t>(linear_unknowns_[static_cast<std::size_t>(i)]);
      const auto& transform = first_.options().unknowns[place].transform;
      now.values[i] = transform.to_parameter(mean[i]);
      now.deviations[i] = transform.slope(mean[i]) * std::sqrt(std::max(0.0, variance[i]));
    }
    return now;
  }

  const AugmentedModel& first_;
  const FilterInput& input_;
  const EstimationOptions& options_;
  std::unique_ptr<FilterSetup> setup_;
  std::vector<Index> linear_unknowns_, linear_states_;  ///< places among the unknowns, and in the state
  LinearEstimate linearised_about_;
  Innovation innovation_;
  VectorXd measured_;
};

}  // namespace

FilterOutcome pass_innovations(const std::shared_ptr<const AugmentedModel>& augmented_model, const FilterInput& input,
                               const EstimationOptions& options, const InnovationSink& keep) {
  return InnovationPass(augmented_model, input, options).run(keep);
}

}  // namespace kalfem
