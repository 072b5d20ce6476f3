// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/identification/step_budget.hpp"

namespace kalfem {

/// A run in which an unknown changes at a sample.
struct ChangeTrial {
  Eigen::Index unknown = 0, sample = 0;
  EstimationResult result;

  [[nodiscard]] double log_likelihood() const {
    return result.failure ? -std::numeric_limits<double>::infinity() : result.log_likelihood;
  }
};

/// Runs over one record about models whose unknowns change, as many as a budget allows. Without their histories: the
/// runs are there to be compared.
class ChangeTrials {
public:
  /// Log-likelihoods of the places that were tried, by sample.
  using Places = std::map<Eigen::Index, double>;

  /// `first`: the first sample that counts. `steps`: filter steps of one run.
  ChangeTrials(const AugmentedModel& augmented_model, const FilterInput& input, EstimationOptions options,
               Eigen::Index first, double steps, StepBudget& budget);

  EstimationResult without_change();
  ChangeTrial with_change(Eigen::Index unknown, Eigen::Index sample);
  /// All these unknowns are renewed before every stretch of so many samples.
  EstimationResult forgetting(const std::vector<Eigen::Index>& unknowns, Eigen::Index stretch);
  /// One unknown walks at random: its variance grows by `variance` over a stretch.
  EstimationResult walking(Eigen::Index unknown, Eigen::Index stretch, double variance);

  /// Moves a change to the largest likelihood, to the sample where the budget allows that: first to where innovations
  /// become too large about `step` samples around it, then outwards until the likelihood is clearly lower to either
  /// side, and inwards by halved steps. Beside the true place the likelihood may have several crests, as long as states
  /// that the wrong value left behind die out.
  ChangeTrial placed(ChangeTrial best, Eigen::Index step);

  /// Moves a change to where the innovations of its run become too large, within two steps, as long as that is better.
  void follow_onset(ChangeTrial& best, Eigen::Index step);

  /// Allows so many runs beyond the budget, which are taken first.
  void allow_runs(int runs) {
    allowed_ = runs;
    stopped_ = false;
  }
  [[nodiscard]] bool stopped() const { return stopped_; }  ///< the budget allowed no further run
  [[nodiscard]] const Places& places(Eigen::Index unknown) { return places_[unknown]; }
  /// Of a change that an unknown may make, in the filter's state.
  [[nodiscard]] double prior_deviation(Eigen::Index unknown) const;
  [[nodiscard]] Eigen::Index first() const { return first_; }
  [[nodiscard]] Eigen::Index samples() const { return input_.measured.samples(); }

private:
  bool takes_a_run();
  bool tries(Eigen::Index sample, ChangeTrial& best);
  void go_outwards(ChangeTrial& best, Eigen::Index side, Eigen::Index reach);
  void halve_steps(ChangeTrial& best, Eigen::Index from, Eigen::Index to);
  bool moves(ChangeTrial& best, Eigen::Index reach);

  const AugmentedModel& augmented_model_;
  const FilterInput& input_;
  EstimationOptions options_;
  Eigen::Index first_;
  double steps_;
  StepBudget& budget_;
  bool stopped_ = false;
  int allowed_ = 0;  ///< runs beyond the budget
  std::map<Eigen::Index, Places> places_;
};

/// 95 % interval of the place of a change, as far as other places were tried: there the log-likelihood is lower by
/// `unlikely`. No narrower than a sample to either side.
std::pair<Eigen::Index, Eigen::Index> interval_of_place(const ChangeTrials::Places& places, Eigen::Index place,
                                                        double unlikely, Eigen::Index first, Eigen::Index last);

}  // namespace kalfem
