// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/inference/outcome.hpp"

namespace kalfem {

/// The Bayesian inference for summary.json. SI; null where a number is unknown or not finite.
nlohmann::ordered_json inference_summary(const InferenceOutcome& outcome);

/// Sentences and tables as a person reads them on a terminal.
std::string console_inference(const InferenceOutcome& outcome);

/// The same on the page, with a corner plot, profile likelihoods and predictive bands.
Section inference_section(const InferenceOutcome& outcome);

/// What an inference found about one parameter. Nothing where it has no such list, as of a posterior without samples.
struct InferredValues {
  std::string name, unit;
  std::optional<ParameterSummary> prior, posterior;
  std::optional<double> truth, most_probable;
  std::optional<Convergence> convergence;

  /// (mean - truth) / deviation of the posterior.
  [[nodiscard]] std::optional<double> z() const;
  /// Posterior's deviation over the prior's.
  [[nodiscard]] std::optional<double> deviation_left() const;
  /// The data left less than half of the prior's deviation, the limit of IdentifiabilityOptions::weak.
  [[nodiscard]] bool determined() const;
};
std::vector<InferredValues> inferred_values(const InferenceOutcome& outcome);

/// "29.97 ± 0.09": two digits of the deviation and as many of the mean; four digits of the mean without a deviation.
std::string with_deviation(double mean, double deviation);

/// The answer in a few sentences: which parameters are determined and how well, which law, and how many warnings.
std::string inference_answer(const InferenceOutcome& outcome);
/// How it was computed: method, likelihood, samples and what they are worth, evidence, time.
std::string inference_method_words(const InferenceOutcome& outcome);
/// Whether other maxima were looked for, and which share of the prior may lead to one that was missed; empty where the
/// method does not search.
std::string search_words(const InferenceOutcome& outcome);
/// What the data can tell at the posterior's mean, or that of its heaviest mode.
std::string after_words(const InferenceOutcome& outcome);
/// Where the filter's normal distribution differs from the posterior, or that it does not; empty without a filter.
std::string filter_words(const InferenceOutcome& outcome);
/// Why the posterior may not hold, and of which law the evidence.
std::vector<std::string> inference_warnings(const InferenceOutcome& outcome);
/// The most probable law and how it stands against the next; empty without laws.
std::string law_words(const InferenceOutcome& outcome);

/// @name Tables
/// Without rows where the outcome has nothing for them; columns without a number are left out.
///@{
Table posterior_table(const InferenceOutcome& outcome);
/// Weight, mean and deviation of each of several modes.
Table mode_table(const InferenceOutcome& outcome);
Table convergence_table(const InferenceOutcome& outcome);
/// Correlation in the posterior, of two parameters or more.
Table posterior_correlation_table(const InferenceOutcome& outcome);
/// Bounds of Cramer and Rao before and after beside the posterior's deviation.
Table identifiability_table(const InferenceOutcome& outcome);
Table filter_table(const InferenceOutcome& outcome);
Table profile_table(const InferenceOutcome& outcome);
Table coverage_table(const InferenceOutcome& outcome);
Table law_table(const LawRanking& ranking);
/// First-order and total index of each parameter, the largest total first, and their 95 % bounds.
Table sobol_table(const InferenceOutcome& outcome, const OutputSensitivity& sensitivity);
///@}

/// Parameters that are drawn: all of up to `most`, otherwise those with the strongest correlations, in their order.
std::vector<Eigen::Index> drawn_parameters(const InferenceOutcome& outcome, std::size_t most);

/// A posterior pair by pair: marginal densities with the prior, the mean and the truth on the diagonal, draws with
/// contours of 50 and 95 % below it, correlations above it. Of more than eight parameters the eight with the strongest
/// correlations. One SVG element in the colours of the page, light and dark. Nothing without finite samples.
std::optional<Picture> corner_plot(const InferenceOutcome& outcome);

}  // namespace kalfem
