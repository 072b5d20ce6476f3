// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "kalfem/diagnosis/candidates.hpp"
#include "kalfem/diagnosis/law_terms.hpp"
#include "kalfem/diagnosis/trial.hpp"
#include "kalfem/diagnosis/trial_plan.hpp"

namespace kalfem {

/// The search for the one mistake that explains a run best: the run is repeated with each undone. Numbers such as gains
/// and delays are first guessed from what the other sensors predict, then searched by likelihood.
class MistakeSearch {
public:
  /// Throws InvalidInput as make_filter_run() does.
  MistakeSearch(DiagnosisInput input, const TrialPlan& plan);

  /// Tests those that are wanted. Once a search.
  Diagnosis run(const std::function<bool(const Hypothesis&)>& wanted = {});

  /// What is searched: the part of the record that the plan allows.
  [[nodiscard]] const DiagnosisInput& input() const { return input_; }
  /// Of this input, as it was given.
  [[nodiscard]] const TrialScore& given() const { return given_; }
  /// Undoes the i-th mistake of `tested`, with the number that was found.
  [[nodiscard]] Undo undo(std::size_t i) const { return undoing(order_[i]); }

private:
  void race();
  [[nodiscard]] bool is_explained_without_laws();
  void look_into_laws(const std::vector<ConnectorMotion>& motion);
  void add_terms(const ConnectorDescription& connector, const ConnectorMotion& motion);
  [[nodiscard]] std::vector<LawTerm> the_next(const std::vector<LawTerm>& terms, std::size_t first,
                                              std::size_t best) const;
  void settle_places(const ConnectorDescription& connector, std::vector<ChosenTerm> known);
  void refine_the_best();
  void refine(std::size_t h, int most_steps);
  void add(Hypothesis hypothesis);
  void try_starts(std::size_t h);
  void try_between(std::size_t h, double unchanged);
  double try_value(std::size_t h, double value);
  [[nodiscard]] double log_likelihood_unchanged() const;
  [[nodiscard]] Eigen::VectorXi measured_samples(Eigen::Index first) const;
  [[nodiscard]] double gain(std::size_t h) const;
  [[nodiscard]] double lowest() const;
  [[nodiscard]] std::vector<std::size_t> best_first() const;
  [[nodiscard]] bool explains(std::size_t h) const;
  [[nodiscard]] std::size_t put_the_simplest_first();
  void settle(std::size_t h);
  [[nodiscard]] Undo undoing(std::size_t h) const;
  void collect(Diagnosis& diagnosis);

  DiagnosisInput input_;
  TrialPlan plan_;
  FilterRun base_;
  EstimationOptions options_;
  TrialScore given_;
  std::vector<Hypothesis> hypotheses_;
  std::vector<TrialScore> scores_;
  std::vector<double> values_;      ///< at which the score stands
  std::vector<std::size_t> order_;  ///< of the hypotheses in Diagnosis::tested
  Eigen::Index samples_ = 0;        ///< that the trials see
};

}  // namespace kalfem
