// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/filter_likelihood.hpp"

#include <cmath>
#include <limits>

#include "kalfem/estimation/innovation_pass.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/likelihood_substeps.hpp"
#include "kalfem/identification/likelihood_unknowns.hpp"
#include "kalfem/identification/named_unknowns.hpp"
#include "kalfem/identification/refined_filter.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// The problem without what costs a likelihood and does not change it.
EstimationProblemPtr lean(const EstimationProblemPtr& problem) {
  if (problem->settings.adaptive_noise.any())
    throw InvalidInput("the noise is to adapt along the record", "a likelihood needs the noise as a parameter",
                       "state the noise, or make it an unknown, and switch adaptive noise off");
  auto own = std::make_shared<EstimationProblem>(*problem);
  own->settings.estimate_initial_state = false;
  return own;
}

/// The filter's model and the record as the filter takes it.
CorrectedProblem corrected_at(const NamedUnknowns& unknowns, const VectorXd& theta, const Record& record,
                              int substeps) {
  const auto problem = unknowns.problem_at(theta);
  IssueList issues;
  auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  setup.options.substeps = substeps;
  auto at = corrected(problem, setup, record, unknowns.likelihood_values(theta));
  unknowns.subtract_offsets(theta, at.record);
  return at;
}

/// As many as an estimation of all unknowns about the first values needs.
int substeps_for(const EstimationProblemPtr& problem, const NamedUnknowns& unknowns, const Record& record) {
  if (problem->settings.substeps) return *problem->settings.substeps;
  auto whole = std::make_shared<EstimationProblem>(*problem);
  for (std::size_t i = 0; i < unknowns.names().size(); ++i) {
    const auto found = std::ranges::find(whole->settings.unknowns, unknowns.names()[i], &Unknown::name);
    if (found != whole->settings.unknowns.end()) found->initial = unknowns.first()[static_cast<Index>(i)];
  }
  IssueList issues;
  const auto setup = make_augmented_model_setup(*whole, whole->structure->parts, {}, issues);
  issues.raise();
  const auto at = corrected(whole, setup, record, unknowns.likelihood_values(unknowns.first()));
  return run_refined_filter(at.problem, at.setup, at.record,
                            {.unscented = whole->settings.unscented,
                             .threads = filter_threads(whole->settings),
                             .state_deviations = false})
      .substeps.substeps;
}

}  // namespace

int likelihood_substeps(const EstimationProblemPtr& problem, const Record& record, std::vector<std::string> names,
                        const VectorXd& first) {
  const EstimationProblemPtr own = lean(problem);
  return substeps_for(own, NamedUnknowns(own, std::move(names), first), record);
}

class FilterLikelihood::Implementation {
public:
  Implementation(const EstimationProblemPtr& problem, Record record, std::vector<std::string> names,
                 const FilterLikelihoodOptions& options)
      : problem_(lean(problem)),
        record_(std::move(record)),
        unknowns_(problem_, std::move(names), options.first),
        substeps_(substeps_for(problem_, unknowns_, record_)) {
    const auto at = corrected_at(unknowns_, unknowns_.first(), record_, substeps_);
    first_run_ = make_filter_run(at.problem, at.setup, at.record);
  }

  [[nodiscard]] const NamedUnknowns& unknowns() const { return unknowns_; }

  [[nodiscard]] std::optional<VectorXd> log_densities(const VectorXd& theta) const {
    const auto at = possible(theta);
    if (!at) return std::nullopt;
    VectorXd densities(record_.samples());
    const bool done = pass(*at, [&](Index k, const Innovation& innovation) {
      densities[k] = innovation.channels.empty() ? 0.0 : innovation.log_likelihood;
    });
    if (!done || !densities.allFinite()) return std::nullopt;
    return VectorXd(densities + at->log_jacobian);
  }

  [[nodiscard]] std::optional<PredictedInnovations> innovations(const VectorXd& theta) const {
    const auto at = possible(theta);
    if (!at) return std::nullopt;
    const VectorXd gains = unknowns_.gains(theta, at->setup.sensors);
    const Index l = gains.size(), samples = record_.samples();
    PredictedInnovations predicted{MatrixXd::Constant(l, samples, not_a_number),
                                   MatrixXd::Constant(l * (l + 1) / 2, samples, not_a_number)};
    bool finite = true;
    const bool done = pass(*at, [&](Index k, const Innovation& innovation) {
      const auto& channels = innovation.channels;
      for (std::size_t i = 0; i < channels.size(); ++i) {
        const Index a = channels[i], place = static_cast<Index>(i);
        predicted.value(a, k) = gains[a] * innovation.value[place];
        for (std::size_t j = 0; j <= i; ++j)
          predicted.covariance(a * (a + 1) / 2 + channels[j], k) =
              gains[a] * gains[channels[j]] * innovation.covariance(place, static_cast<Index>(j));
      }
      finite = finite && (channels.empty() || std::isfinite(innovation.log_likelihood));
    });
    if (!done || !finite) return std::nullopt;
    return predicted;
  }

private:
  /// Empty where theta makes no structure.
  [[nodiscard]] std::optional<CorrectedProblem> possible(const VectorXd& theta) const {
    if (theta.size() != unknowns_.first().size())
      throw InvalidInput(
          std::to_string(theta.size()) + " values for " + std::to_string(unknowns_.first().size()) + " named unknowns",
          "there must be one each", "");
    if (!unknowns_.admissible(theta)) return std::nullopt;
    try {
      return corrected_at(unknowns_, theta, record_, substeps_);
    } catch (const InvalidInput&) {
      return std::nullopt;
    }
  }

  /// Through the filter of the first values, and where rounding stops it through its safer forms (attempts_after()).
  /// Whether one ran to the end.
  [[nodiscard]] bool pass(const CorrectedProblem& at, const InnovationSink& keep) const try {
    const auto& choice = first_run_.choice;
    std::vector<FilterAttempt> attempts{{choice.filter, choice.augmented_model->options().coordinates, {}}};
    for (std::size_t i = 0; i < attempts.size(); ++i) {
      const FilterRun run = make_filter_run_like(first_run_, at.problem, at.setup, at.record, attempts[i].coordinates);
      const auto outcome =
          pass_innovations(run.choice.augmented_model, run.input,
                           {.filter = attempts[i].filter, .unscented = problem_->settings.unscented}, keep);
      if (outcome == FilterOutcome::usable) return true;
      if (i > 0) continue;
      FilterAttempt failed = attempts.front();
      failed.failure = EstimationFailure{.outcome = outcome};
      const auto next = attempts_after(failed, problem_->settings.filter.has_value());
      attempts.insert(attempts.end(), next.begin(), next.end());
    }
    return false;
  } catch (const InvalidInput&) {
    return false;
  }

  EstimationProblemPtr problem_;
  Record record_;
  NamedUnknowns unknowns_;
  int substeps_;
  FilterRun first_run_;
};

FilterLikelihood::FilterLikelihood(const EstimationProblemPtr& problem, Record record, std::vector<std::string> names,
                                   const FilterLikelihoodOptions& options)
    : implementation_(std::make_shared<const Implementation>(problem, std::move(record), std::move(names), options)) {}

const std::vector<std::string>& FilterLikelihood::names() const { return implementation_->unknowns().names(); }

const VectorXd& FilterLikelihood::first() const { return implementation_->unknowns().first(); }

std::optional<VectorXd> FilterLikelihood::log_densities(const VectorXd& theta) const {
  return implementation_->log_densities(theta);
}

double FilterLikelihood::log_likelihood(const VectorXd& theta) const {
  const auto densities = log_densities(theta);
  return densities ? densities->sum() : -std::numeric_limits<double>::infinity();
}

std::optional<PredictedInnovations> FilterLikelihood::innovations(const VectorXd& theta) const {
  return implementation_->innovations(theta);
}

}  // namespace kalfem
