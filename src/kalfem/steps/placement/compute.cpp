// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/placement/compute.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/information/identifiability.hpp"
#include "kalfem/steps/placement/outcome.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Set = std::vector<std::size_t>;

namespace {

constexpr std::size_t most_best = 20;

/// Information of each candidate at one value of the unknowns, p x p [1/(unit_i unit_j)].
using CandidateMatrices = std::vector<MatrixXd>;

std::optional<CandidateMatrices> information_at(const Study& study, const VectorXd& values) {
  const auto& plan = *study.placement;
  FisherInformationOptions options{.relative_step = 1e-4, .scale = values.cwiseAbs(), .threads = plan.options.threads};
  for (Index i = 0; i < values.size(); ++i)
    if (values[i] == 0.0) options.scale[i] = plan.prior.deviation()[i];
  return candidate_information(study.problem, plan.drive, plan.candidates, plan.unknowns, values, options);
}

/// What sets of candidates tell of the unknowns at some values of these.
class ExpectedInformation {
public:
  ExpectedInformation(const PlacementPlan& plan, std::vector<CandidateMatrices> at_values)
      : counted_(static_cast<Index>(plan.counted)),
        prior_(plan.prior.deviation().cwiseAbs2().cwiseInverse()),
        at_values_(std::move(at_values)) {}

  /// Of all unknowns, without the prior, one matrix for each value.
  [[nodiscard]] std::vector<MatrixXd> of_all(const Set& set) const {
    std::vector<MatrixXd> sums;
    for (const auto& matrices : at_values_) {
      MatrixXd sum = MatrixXd::Zero(prior_.size(), prior_.size());
      for (const auto i : set) sum += matrices[i];
      sums.push_back(std::move(sum));
    }
    return sums;
  }

  /// Of the counted unknowns c, without their prior, while the others o are unknown under theirs:
  ///     I_cc - I_co (I_oo + P_o^-1)^-1 I_oc.
  [[nodiscard]] std::vector<MatrixXd> of_counted(const Set& set) const {
    const Index others = prior_.size() - counted_;
    std::vector<MatrixXd> information = of_all(set);
    if (others == 0) return information;
    for (auto& matrix : information) {
      const MatrixXd across = matrix.topRightCorner(counted_, others);
      MatrixXd own = matrix.bottomRightCorner(others, others);
      own.diagonal() += prior_.tail(others);
      const MatrixXd left = matrix.topLeftCorner(counted_, counted_) - across * own.ldlt().solve(across.transpose());
      matrix = 0.5 * (left + left.transpose());
    }
    return information;
  }

  /// Posterior deviations of the counted unknowns, root mean square over the values.
  [[nodiscard]] VectorXd deviation(const Set& set) const {
    VectorXd variance = VectorXd::Zero(counted_);
    for (MatrixXd& matrix : of_counted(set)) {
      matrix.diagonal() += prior_.head(counted_);
      variance += matrix.ldlt().solve(MatrixXd::Identity(counted_, counted_)).diagonal();
    }
    return (variance / static_cast<double>(at_values_.size())).cwiseMax(0.0).cwiseSqrt();
  }

  [[nodiscard]] bool moves(std::size_t candidate) const {
    return std::ranges::any_of(at_values_, [&](const auto& matrices) { return !matrices[candidate].isZero(0.0); });
  }

private:
  Index counted_;
  VectorXd prior_;  ///< information of the prior
  std::vector<CandidateMatrices> at_values_;
};

/// Substeps bias estimates, and these are known here: their deviations hardly depend on the step.
constexpr int enough_for_deviations = 8;

/// Runs the filter over the expected record of a set, in which noise is stated but not added.
class FilterCheck {
public:
  explicit FilterCheck(const Study& study) : study_(study) {}

  /// Deviations of the counted unknowns at the end; empty where the filter fails.
  [[nodiscard]] VectorXd deviation(const Set& set) const try {
    const auto& plan = *study_.placement;
    const auto problem = problem_with(set);
    const auto record = expected_record(problem, plan.drive, {}, VectorXd());
    if (!record) return {};
    IssueList issues;
    auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
    issues.raise();
    const auto estimate = estimate_record(problem, setup, *record);
    if (estimate.result.failure) return {};
    VectorXd deviation(static_cast<Index>(plan.counted));
    const auto& unknowns = estimate.augmented_model->options().unknowns;
    for (std::size_t i = 0; i < plan.counted; ++i) {
      const auto found = std::ranges::find(unknowns, plan.unknowns[i], &UnknownParameter::name);
      deviation[static_cast<Index>(i)] =
          estimate.result.unknowns.deviation(found - unknowns.begin(), estimate.result.unknowns.deviation.cols() - 1);
    }
    return deviation;
  } catch (const InvalidInput&) {
    return {};
  }

private:
  [[nodiscard]] EstimationProblemPtr problem_with(const Set& set) const {
    std::vector<CandidateSensor> sensors;
    for (const auto i : set) sensors.push_back(study_.placement->candidates[i]);
    EstimationProblem problem = *with_sensors(*study_.problem, sensors);
    auto& settings = problem.settings;
    settings.local.reset();
    settings.likelihood_unknowns.clear();
    settings.adaptive_noise = {};
    settings.outliers = OutlierTreatment::keep;
    settings.diagnose = settings.smooth = false;
    settings.threads = 1;
    if (!settings.substeps) settings.substeps = enough_for_deviations;
    return std::make_shared<const EstimationProblem>(std::move(problem));
  }

  const Study& study_;
};

/// Chooses the sets, then what a reader wants to know of the choice.
class PlacementRun {
public:
  PlacementRun(const Study& study, const Progress& progress)
      : study_(study), plan_(*study.placement), progress_(progress) {}

  PlacementOutcome run() {
    const Stopwatch watch;
    describe();
    if (compute_information()) {
      choose();
      rank_candidates();
      compare_own();
      check_by_filter();
      remark();
    }
    outcome_.seconds = watch.seconds();
    return std::move(outcome_);
  }

private:
  void tell(const char* step, double fraction) const {
    if (progress_) progress_(step, fraction);
  }

  void describe() {
    const auto counted = static_cast<std::ptrdiff_t>(plan_.counted);
    outcome_.parameters = {plan_.unknowns.begin(), plan_.unknowns.begin() + counted};
    outcome_.units = {plan_.units.begin(), plan_.units.begin() + counted};
    outcome_.prior = plan_.prior.deviation().head(counted);
    outcome_.criterion = plan_.options.criterion;
  }

  /// At the initial values, and at the draws if there are several. Values under which the structure cannot be simulated
  /// are left out.
  bool compute_information() {
    const auto initial = information_at(study_, plan_.initial);
    if (!initial) {
      outcome_.failure = "the expected record cannot be simulated at the initial values of the unknowns";
      return false;
    }
    at_initial_.emplace(plan_, std::vector<CandidateMatrices>{*initial});
    std::vector<CandidateMatrices> at_draws;
    if (plan_.draws == 1) at_draws.push_back(*initial);
    RandomStream random(plan_.seed, "placement");
    for (int draw = 0; plan_.draws > 1 && draw < plan_.draws; ++draw) {
      tell("expected information", 0.6 * static_cast<double>(draw) / plan_.draws);
      if (auto found = information_at(study_, plan_.prior.sample(random))) at_draws.push_back(std::move(*found));
    }
    const auto failed = plan_.draws - static_cast<int>(at_draws.size());
    if (failed > 0)
      outcome_.remarks.push_back(std::to_string(failed) + " of " + std::to_string(plan_.draws) +
                                 " draws from the priors are left out: the structure cannot be simulated there.");
    outcome_.draws = std::ssize(at_draws);
    if (at_draws.empty()) outcome_.failure = "the structure cannot be simulated at any draw from the priors";
    expected_.emplace(plan_, std::move(at_draws));
    return outcome_.failure.empty();
  }

  [[nodiscard]] PlacedSet placed(const Set& set, double criterion, std::optional<std::size_t> rank) const {
    return {set, rank, criterion, expected_->deviation(set)};
  }

  void choose() {
    tell("ranking of sets", 0.6);
    std::vector<SensorCandidate> candidates;
    for (const auto& candidate : plan_.candidates) candidates.push_back({candidate.name});
    outcome_.placement = place_sensors(
        candidates, [&](const Set& set) { return std::optional(expected_->of_counted(set)); }, plan_.options);
    const auto& sets = outcome_.placement.sets;
    for (std::size_t i = 0; i < std::min(sets.size(), most_best); ++i)
      outcome_.best.push_back(placed(sets[i].candidates, sets[i].criterion, i));
  }

  [[nodiscard]] Set kept() const {
    Set set(plan_.options.fixed.size());
    std::iota(set.begin(), set.end(), 0);
    return set;
  }

  /// Each alone, or beside the sensors that stay.
  void rank_candidates() {
    const Set beside = kept();
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < plan_.candidates.size(); ++i) {
      CandidateRank rank{.name = plan_.candidates[i].name, .kept = i < beside.size(), .moves = expected_->moves(i)};
      Set set = beside;
      if (!rank.kept) {
        set.push_back(i);
        order.push_back(i);
      }
      rank.criterion = placement_criterion(expected_->of_counted(set), plan_.options);
      rank.left = std::sqrt((expected_->deviation(set).array() / outcome_.prior.array()).square().mean());
      outcome_.candidates.push_back(std::move(rank));
    }
    std::ranges::stable_sort(order, std::ranges::greater{},
                             [&](std::size_t i) { return outcome_.candidates[i].criterion; });
    for (std::size_t place = 0; place < order.size(); ++place) outcome_.candidates[order[place]].rank = place;
  }

  void compare_own() {
    if (plan_.own.empty()) return;
    const auto& sets = outcome_.placement.sets;
    const auto found = std::ranges::find(sets, plan_.own, &RankedSet::candidates);
    std::optional<std::size_t> rank;
    if (found != sets.end()) rank = static_cast<std::size_t>(found - sets.begin());
    outcome_.own = placed(plan_.own, placement_criterion(expected_->of_counted(plan_.own), plan_.options), rank);
  }

  /// The best set, two between, the worst and the case's own.
  void check_by_filter() {
    const auto last = outcome_.placement.sets.size() - 1;
    std::vector<std::size_t> ranks = {0, last / 3, 2 * last / 3, last};
    if (outcome_.own && outcome_.own->rank) ranks.push_back(*outcome_.own->rank);
    std::ranges::sort(ranks);
    const auto same = std::ranges::unique(ranks);
    ranks.erase(same.begin(), same.end());
    for (const auto rank : ranks) {
      const auto& [set, criterion] = outcome_.placement.sets[rank];
      outcome_.checked.push_back({{set, rank, criterion, at_initial_->deviation(set)}});
    }
    if (outcome_.own && !outcome_.own->rank) {
      outcome_.checked.push_back({*outcome_.own});
      outcome_.checked.back().set.bound = at_initial_->deviation(outcome_.own->candidates);
    }
    tell("filter over expected records", 0.8);
    const FilterCheck filter(study_);
    for_each_index(outcome_.checked.size(), plan_.options.threads, [&](std::size_t i) {
      outcome_.checked[i].filter = filter.deviation(outcome_.checked[i].set.candidates);
    });
  }

  void remark() {
    std::vector<InformedParameter> parameters;
    const VectorXd deviation = plan_.prior.deviation();
    for (std::size_t i = 0; i < plan_.unknowns.size(); ++i) {
      const auto index = static_cast<Index>(i);
      parameters.push_back({plan_.unknowns[i], plan_.initial[index], deviation[index]});
    }
    const Set& best = outcome_.placement.best().candidates;
    outcome_.remarks.push_back("With the best set: " +
                               identifiability(at_initial_->of_all(best).front(), parameters).text);
    remark_hidden();
    constexpr std::size_t most_named = 10;
    std::vector<std::string> still;
    for (const auto& candidate : outcome_.candidates)
      if (!candidate.moves) still.push_back(candidate.name);
    if (still.empty()) return;
    std::string names;
    for (std::size_t i = 0; i < std::min(still.size(), most_named); ++i) names += (i == 0 ? "" : ", ") + still[i];
    if (still.size() > most_named) names += " and " + std::to_string(still.size() - most_named) + " more";
    outcome_.remarks.push_back(
        "Under the case's excitation these candidates do not move, or not with the unknowns, so "
        "they tell nothing: " +
        names + ".");
  }

  /// What the ranking does not know: the filter has process noise and may have an unknown start.
  void remark_hidden() {
    constexpr double much = 1.5;
    double largest = 0.0;
    for (const auto& [set, filter] : outcome_.checked)
      if (filter.size() > 0) largest = std::max(largest, filter.cwiseQuotient(set.bound).maxCoeff());
    if (largest > much)
      outcome_.remarks.push_back(
          "A run of the filter leaves deviations up to " + shortest(std::round(10.0 * largest) / 10.0) +
          " times the bound: process noise or an unknown start hides a part of what the sensors tell. Sets are ranked "
          "without it.");
    remark_other_order();
  }

  /// Where a set that ranks lower leaves smaller deviations in the filter than the best one.
  void remark_other_order() {
    constexpr double clearly = 0.95;
    const auto left = [&](const CheckedSet& checked) {
      return checked.filter.size() > 0 ? checked.filter.cwiseQuotient(outcome_.prior).norm()
                                       : std::numeric_limits<double>::infinity();
    };
    const auto best = std::ranges::min_element(outcome_.checked, {}, left);
    const double ratio = left(*best) / left(outcome_.checked.front());
    if (!(ratio < clearly)) return;
    std::string names;
    for (const auto i : best->set.candidates) names += (names.empty() ? "" : ", ") + plan_.candidates[i].name;
    outcome_.remarks.push_back("By the filter the best set is not the best: " + names + " leave deviations " +
                               shortest(std::round(100.0 * ratio) / 100.0) +
                               " times as large. The ranking by the bound does not hold for the filter here.");
  }

  const Study& study_;
  const PlacementPlan& plan_;
  const Progress& progress_;
  std::optional<ExpectedInformation> at_initial_, expected_;
  PlacementOutcome outcome_;
};

}  // namespace

PlacementOutcome run_placement(const Study& study, const Progress& progress) {
  return PlacementRun(study, progress).run();
}

}  // namespace kalfem
