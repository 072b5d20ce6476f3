// SPDX-License-Identifier: Apache-2.0
#include "kalfem/placement/placement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/information/identifiability.hpp"
#include "kalfem/placement/expected_information.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;
using Set = std::vector<std::size_t>;

namespace {

constexpr std::size_t most_best = 20;

/// Substeps bias estimates, and these are known here: their deviations hardly depend on the step.
constexpr int enough_for_deviations = 8;  // instants of the connectors' forces

EstimationProblemPtr problem_with(const PlacementProblem& placement, const Set& set) {
  std::vector<CandidateSensor> sensors;
  for (const auto i : set) sensors.push_back(placement.candidates[i]);
  EstimationProblem problem = *with_sensors(*placement.problem, sensors);
  auto& settings = problem.settings;
  settings.local.reset();
  settings.likelihood_unknowns.clear();
  settings.adaptive_noise = {};
  settings.outliers = OutlierTreatment::keep;
  settings.diagnose = settings.smooth = false;
  settings.threads = 1;
  if (!settings.substeps) settings.substeps = 2 * enough_for_deviations / settings.step_order;
  return std::make_shared<const EstimationProblem>(std::move(problem));
}

/// Deviations of the counted unknowns after a run of the filter over the expected record of a set, in which noise is
/// stated but not added; empty where the filter fails.
VectorXd deviation_by_filter(const PlacementProblem& placement, const Set& set) try {
  const auto problem = problem_with(placement, set);
  const auto record = expected_record(problem, placement.drive, {}, VectorXd());
  if (!record) return {};
  IssueList issues;
  const auto setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  const auto estimate = estimate_record(problem, setup, *record);
  if (estimate.result.failure) return {};
  VectorXd deviation(static_cast<Index>(placement.counted));
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < placement.counted; ++i) {
    const auto found = std::ranges::find(unknowns, placement.unknowns[i], &UnknownParameter::name);
    deviation[static_cast<Index>(i)] =
        estimate.result.unknowns.deviation(found - unknowns.begin(), estimate.result.unknowns.deviation.cols() - 1);
  }
  return deviation;
} catch (const InvalidInput&) {
  return {};
}

/// Chooses the sets, then what a reader wants to know of the choice.
class PlacementRun {
public:
  PlacementRun(const PlacementProblem& problem, const Progress& progress) : problem_(problem), progress_(progress) {}

  SensorChoice run() {
    const Stopwatch watch;
    describe();
    if (compute_information()) {
      choose();
      rank_candidates();
      compare_own();
      check_by_filter();
      remark();
    }
    found_.seconds = watch.seconds();
    return std::move(found_);
  }

private:
  void tell(const char* step, double fraction) const {
    if (progress_) progress_(step, fraction);
  }

  void describe() {
    const auto counted = static_cast<std::ptrdiff_t>(problem_.counted);
    found_.parameters = {problem_.unknowns.begin(), problem_.unknowns.begin() + counted};
    found_.units = {problem_.units.begin(), problem_.units.begin() + counted};
    found_.prior = problem_.prior.deviation().head(counted);
    found_.criterion = problem_.options.criterion;
  }

  /// At the initial values, and at the draws if there are several. Values under which the structure cannot be simulated
  /// are left out.
  bool compute_information() {
    const auto initial = information_at(problem_, problem_.initial);
    if (!initial) {
      found_.failure = "the expected record cannot be simulated at the initial values of the unknowns";
      return false;
    }
    at_initial_.emplace(problem_, std::vector<CandidateMatrices>{*initial});
    std::vector<CandidateMatrices> at_draws;
    if (problem_.draws == 1) at_draws.push_back(*initial);
    RandomStream random(problem_.seed, "placement");
    for (int draw = 0; problem_.draws > 1 && draw < problem_.draws; ++draw) {
      tell("expected information", 0.6 * static_cast<double>(draw) / problem_.draws);
      if (auto found = information_at(problem_, problem_.prior.sample(random))) at_draws.push_back(std::move(*found));
    }
    const auto failed = problem_.draws - static_cast<int>(at_draws.size());
    if (failed > 0)
      found_.remarks.push_back(std::to_string(failed) + " of " + std::to_string(problem_.draws) +
                               " draws from the priors are left out: the structure cannot be simulated there.");
    found_.draws = std::ssize(at_draws);
    if (at_draws.empty()) found_.failure = "the structure cannot be simulated at any draw from the priors";
    expected_.emplace(problem_, std::move(at_draws));
    return found_.failure.empty();
  }

  [[nodiscard]] PlacedSet placed(const Set& set, double criterion, std::optional<std::size_t> rank) const {
    return {set, rank, criterion, expected_->deviation(set)};
  }

  void choose() {
    tell("ranking of sets", 0.6);
    std::vector<SensorCandidate> candidates;
    for (const auto& candidate : problem_.candidates) candidates.push_back({candidate.name});
    found_.placement = place_sensors(
        candidates, [&](const Set& set) { return std::optional(expected_->of_counted(set)); }, problem_.options);
    const auto& sets = found_.placement.sets;
    for (std::size_t i = 0; i < std::min(sets.size(), most_best); ++i)
      found_.best.push_back(placed(sets[i].candidates, sets[i].criterion, i));
  }

  [[nodiscard]] Set kept() const {
    Set set(problem_.options.fixed.size());
    std::iota(set.begin(), set.end(), 0);
    return set;
  }

  /// Each alone, or beside the sensors that stay.
  void rank_candidates() {
    const Set beside = kept();
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < problem_.candidates.size(); ++i) {
      CandidateRank rank{.name = problem_.candidates[i].name, .kept = i < beside.size(), .moves = expected_->moves(i)};
      Set set = beside;
      if (!rank.kept) {
        set.push_back(i);
        order.push_back(i);
      }
      rank.criterion = placement_criterion(expected_->of_counted(set), problem_.options);
      rank.left = std::sqrt((expected_->deviation(set).array() / found_.prior.array()).square().mean());
      found_.candidates.push_back(std::move(rank));
    }
    std::ranges::stable_sort(order, std::ranges::greater{},
                             [&](std::size_t i) { return found_.candidates[i].criterion; });
    for (std::size_t place = 0; place < order.size(); ++place) found_.candidates[order[place]].rank = place;
  }

  void compare_own() {
    if (problem_.own.empty()) return;
    const auto& sets = found_.placement.sets;
    const auto found = std::ranges::find(sets, problem_.own, &RankedSet::candidates);
    std::optional<std::size_t> rank;
    if (found != sets.end()) rank = static_cast<std::size_t>(found - sets.begin());
    found_.own = placed(problem_.own, placement_criterion(expected_->of_counted(problem_.own), problem_.options), rank);
  }

  /// The best set, two between, the worst and the problem's own.
  void check_by_filter() {
    const auto last = found_.placement.sets.size() - 1;
    std::vector<std::size_t> ranks = {0, last / 3, 2 * last / 3, last};
    if (found_.own && found_.own->rank) ranks.push_back(*found_.own->rank);
    std::ranges::sort(ranks);
    const auto same = std::ranges::unique(ranks);
    ranks.erase(same.begin(), same.end());
    for (const auto rank : ranks) {
      const auto& [set, criterion] = found_.placement.sets[rank];
      found_.checked.push_back({{set, rank, criterion, at_initial_->deviation(set)}});
    }
    if (found_.own && !found_.own->rank) {
      found_.checked.push_back({*found_.own});
      found_.checked.back().set.bound = at_initial_->deviation(found_.own->candidates);
    }
    tell("filter over expected records", 0.8);
    for_each_index(found_.checked.size(), problem_.options.threads, [&](std::size_t i) {
      found_.checked[i].filter = deviation_by_filter(problem_, found_.checked[i].set.candidates);
    });
  }

  void remark() {
    std::vector<InformedParameter> parameters;
    const VectorXd deviation = problem_.prior.deviation();
    for (std::size_t i = 0; i < problem_.unknowns.size(); ++i) {
      const auto index = static_cast<Index>(i);
      parameters.push_back({problem_.unknowns[i], problem_.initial[index], deviation[index]});
    }
    const Set& best = found_.placement.best().candidates;
    found_.remarks.push_back("With the best set: " +
                             identifiability(at_initial_->of_all(best).front(), parameters).text);
    remark_hidden();
    if (!problem_.not_counted.empty())
      found_.remarks.push_back(
          "Numbers of the structure that known_to states are unknown beside the others; gains and "
          "delays, such as '" +
          problem_.not_counted.front() + "', are taken as exact here.");
    constexpr std::size_t most_named = 10;
    std::vector<std::string> still;
    for (const auto& candidate : found_.candidates)
      if (!candidate.moves) still.push_back(candidate.name);
    if (still.empty()) return;
    std::string names;
    for (std::size_t i = 0; i < std::min(still.size(), most_named); ++i) names += (i == 0 ? "" : ", ") + still[i];
    if (still.size() > most_named) names += " and " + std::to_string(still.size() - most_named) + " more";
    found_.remarks.push_back(
        "Under the excitation these candidates do not move, or not with the unknowns, so "
        "they tell nothing: " +
        names + ".");
  }

  /// What the ranking does not know: the filter has process noise and may have an unknown start.
  void remark_hidden() {
    constexpr double much = 1.5;
    double largest = 0.0;
    for (const auto& [set, filter] : found_.checked)
      if (filter.size() > 0) largest = std::max(largest, filter.cwiseQuotient(set.bound).maxCoeff());
    if (largest > much)
      found_.remarks.push_back(
          "A run of the filter leaves deviations up to " + shortest(std::round(10.0 * largest) / 10.0) +
          " times the bound: process noise or an unknown start hides a part of what the sensors tell. Sets are ranked "
          "without it.");
    remark_other_order();
  }

  /// Where a set that ranks lower leaves smaller deviations in the filter than the best one.
  void remark_other_order() {
    constexpr double clearly = 0.95;
    const auto left = [&](const CheckedSet& checked) {
      return checked.filter.size() > 0 ? checked.filter.cwiseQuotient(found_.prior).norm()
                                       : std::numeric_limits<double>::infinity();
    };
    const auto best = std::ranges::min_element(found_.checked, {}, left);
    const double ratio = left(*best) / left(found_.checked.front());
    if (!(ratio < clearly)) return;
    std::string names;
    for (const auto i : best->set.candidates) names += (names.empty() ? "" : ", ") + problem_.candidates[i].name;
    found_.remarks.push_back("By the filter the best set is not the best: " + names + " leave deviations " +
                             shortest(std::round(100.0 * ratio) / 100.0) +
                             " times as large. The ranking by the bound does not hold for the filter here.");
  }

  const PlacementProblem& problem_;
  const Progress& progress_;
  std::optional<ExpectedInformation> at_initial_, expected_;
  SensorChoice found_;
};

}  // namespace

std::vector<std::string> SensorChoice::names(const PlacedSet& set) const {
  std::vector<std::string> names;
  for (const auto i : set.candidates) names.push_back(candidates[i].name);
  return names;
}

SensorChoice place(const PlacementProblem& problem, const Progress& progress) {
  return PlacementRun(problem, progress).run();
}

}  // namespace kalfem
