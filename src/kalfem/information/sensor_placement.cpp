// SPDX-License-Identifier: Apache-2.0
#include "kalfem/information/sensor_placement.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <thread>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/parallel.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Set = std::vector<std::size_t>;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double singular = 1e-13;    ///< smallest to largest eigenvalue below which a matrix is not invertible
constexpr double least_gain = 1e-10;  ///< of the criterion, relative, for an exchange

VectorXd scale_of(Index parameters, const SensorPlacementOptions& options) {
  return options.scale.size() > 0 ? options.scale : VectorXd::Ones(parameters);
}

VectorXd prior_information(const VectorXd& scale, const SensorPlacementOptions& options) {
  if (options.prior_deviation.size() == 0) return VectorXd::Zero(scale.size());
  return (scale.array() / options.prior_deviation.array()).square();
}

/// ln det of a matrix with those eigenvalues, the smaller ones raised to `floor`.
double log_determinant(const VectorXd& eigenvalues, double floor) { return eigenvalues.array().max(floor).log().sum(); }

double chosen_variance(const VectorXd& variances, const std::vector<std::size_t>& chosen) {
  if (chosen.empty()) return variances.mean();
  double sum = 0.0;
  for (const auto i : chosen) sum += variances[static_cast<Index>(i)];
  return sum / static_cast<double>(chosen.size());
}

double criterion_of(const MatrixXd& information, const SensorPlacementOptions& options) {
  const VectorXd scale = scale_of(information.rows(), options), prior = prior_information(scale, options);
  MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  scaled.diagonal() += prior;
  if (!scaled.allFinite()) return -infinity;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  const VectorXd& values = eigen.eigenvalues();
  if (options.criterion == PlacementCriterion::e_optimality) return values[0];
  if (values[0] <= singular * values[values.size() - 1]) return -infinity;
  if (options.criterion == PlacementCriterion::d_optimality)
    return log_determinant(values, 0.0) - 2.0 * scale.array().log().sum();
  if (options.criterion == PlacementCriterion::mutual_information)
    return 0.5 * (log_determinant(values, 0.0) - prior.array().log().sum());
  const VectorXd variances = eigen.eigenvectors().array().square().matrix() * values.cwiseInverse();
  if (options.criterion == PlacementCriterion::a_optimality) return -variances.sum();
  return -std::sqrt(chosen_variance(variances, options.parameters));
}

/// Tells sets apart that leave parameters undetermined: the informed directions count, the others stand at a floor.
double substitute(const std::vector<MatrixXd>& information, const SensorPlacementOptions& options) {
  double sum = 0.0;
  for (const auto& each : information) {
    const VectorXd scale = scale_of(each.rows(), options);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(scale.asDiagonal() * each * scale.asDiagonal()),
                                                        Eigen::EigenvaluesOnly);
    sum += (eigen.eigenvalues().array().max(0.0) + 1e-12).log().sum();
  }
  return sum;
}

struct Score {
  double criterion = -infinity, substitute = -infinity;
  bool failed = false;

  [[nodiscard]] bool better_than(const Score& other) const {
    if (std::isinf(criterion) && std::isinf(other.criterion)) return substitute > other.substitute;
    if (std::isinf(criterion) || std::isinf(other.criterion)) return criterion > other.criterion;
    return criterion > other.criterion + least_gain * std::abs(other.criterion);
  }
};

double number_of_sets(std::size_t of, std::size_t take) {
  double count = 1.0;
  for (std::size_t i = 0; i < take; ++i) count *= static_cast<double>(of - i) / static_cast<double>(i + 1);
  return std::round(count);
}

class Search {
public:
  Search(std::size_t candidates, Set fixed, const SetInformation& information, const SensorPlacementOptions& options)
      : fixed_(std::move(fixed)), information_(information), options_(options) {
    for (std::size_t i = 0; i < candidates; ++i)
      if (std::ranges::find(fixed_, i) == fixed_.end()) free_.push_back(i);
    threads_ = options.threads > 0 ? options.threads : processors();
  }

  SensorPlacement run() {
    result_.exact = number_of_sets(free_.size(), open()) <= options_.most_sets;
    return ranked(result_.exact ? score(all_sets()) : searched());
  }

private:
  using Scored = std::vector<std::pair<Set, Score>>;

  [[nodiscard]] std::size_t open() const { return options_.sensors - fixed_.size(); }

  [[nodiscard]] Set with_fixed(Set set) const {
    set.insert(set.end(), fixed_.begin(), fixed_.end());
    std::ranges::sort(set);
    return set;
  }

  [[nodiscard]] std::vector<Set> all_sets() const {
    std::vector<Set> sets;
    std::vector<bool> taken(free_.size(), false);
    std::fill_n(taken.begin(), open(), true);
    do {
      Set set;
      for (std::size_t i = 0; i < free_.size(); ++i)
        if (taken[i]) set.push_back(free_[i]);
      sets.push_back(with_fixed(std::move(set)));
    } while (std::prev_permutation(taken.begin(), taken.end()));
    return sets;
  }

  Score score_of(const Set& set) const {
    stop_if_asked();
    const auto information = information_(set);
    if (!information) return {-infinity, -infinity, true};
    return {placement_criterion(*information, options_), substitute(*information, options_), false};
  }

  Scored score(const std::vector<Set>& sets) {
    Scored scored(sets.size());
    for_each_index(sets.size(), threads_, [&](std::size_t i) { scored[i] = {sets[i], score_of(sets[i])}; });
    result_.tried += static_cast<double>(sets.size());
    for (const auto& [set, score] : scored) result_.failed += score.failed ? 1 : 0;
    return scored;
  }

  [[nodiscard]] static const std::pair<Set, Score>& best_of(const Scored& scored) {
    const auto* best = &scored.front();
    for (const auto& each : scored)
      if (each.second.better_than(best->second)) best = &each;
    return *best;
  }

  /// Sets with one candidate more.
  [[nodiscard]] std::vector<Set> enlarged(const Set& set) const {
    std::vector<Set> sets;
    for (const auto candidate : free_) {
      if (std::ranges::find(set, candidate) != set.end()) continue;
      sets.push_back(set);
      sets.back().push_back(candidate);
      std::ranges::sort(sets.back());
    }
    return sets;
  }

  /// From the best set of two greedy ones: by the criterion, and by the determinant, as a set that lacks one good
  /// sensor says little of the smallest eigenvalue that it will have in the end.
  Scored searched() {
    const auto better = [](const Score& a, const Score& b) { return a.better_than(b); };
    Scored found = exchanged(greedy(better));
    if (options_.criterion == PlacementCriterion::d_optimality) return found;
    Scored other = exchanged(greedy([](const Score& a, const Score& b) { return a.substitute > b.substitute; }));
    return best_of(other).second.better_than(best_of(found).second) ? other : found;
  }

  /// Adds one sensor after the other, each the best beside those before.
  template <class Better>
  std::pair<Set, Score> greedy(const Better& better) {
    std::pair<Set, Score> best{with_fixed({}), {}};
    while (best.first.size() < options_.sensors) {
      const Scored scored = score(enlarged(best.first));
      best = scored.front();
      for (const auto& each : scored)
        if (better(each.second, best.second)) best = each;
    }
    return best;
  }

  /// Exchanges one sensor for another, the best exchange of all first, as long as that helps. The sets of the last
  /// round, in which none did, are the neighbours of the best.
  Scored exchanged(std::pair<Set, Score> best) {
    for (;;) {
      std::vector<Set> neighbours;
      for (const auto candidate : best.first) {
        if (std::ranges::find(fixed_, candidate) != fixed_.end()) continue;
        Set rest = best.first;
        std::erase(rest, candidate);
        for (auto& set : enlarged(rest))
          if (set != best.first) neighbours.push_back(std::move(set));
      }
      Scored round{best};
      if (neighbours.empty()) return round;
      const Scored scored = score(neighbours);
      round.insert(round.end(), scored.begin(), scored.end());
      const auto& next = best_of(round);
      if (next.first == best.first) return round;
      best = next;
    }
  }

  SensorPlacement ranked(Scored scored) {
    std::ranges::stable_sort(scored, [](const auto& a, const auto& b) {
      return std::pair(a.second.criterion, a.second.substitute) > std::pair(b.second.criterion, b.second.substitute);
    });
    if (scored.size() > options_.ranked) scored.resize(std::max<std::size_t>(1, options_.ranked));
    for (auto& [set, score] : scored) result_.sets.push_back({std::move(set), score.criterion});
    return std::move(result_);
  }

  Set fixed_, free_;
  const SetInformation& information_;
  const SensorPlacementOptions& options_;
  int threads_ = 1;
  SensorPlacement result_;
};

void check_names(const std::vector<SensorCandidate>& candidates, const SensorPlacementOptions& options,
                 IssueList& issues) {
  std::vector<std::string> names;
  for (const auto& candidate : candidates) {
    if (std::ranges::find(names, candidate.name) != names.end())
      issues.add({}, "the candidate '" + candidate.name + "' is given twice", "a sensor stands in one place once",
                 "give every candidate its own name");
    names.push_back(candidate.name);
  }
  std::set<std::string> fixed;
  for (const auto& name : options.fixed) {
    if (std::ranges::find(names, name) == names.end())
      issues.add({}, "the fixed sensor '" + name + "' is not a candidate" + did_you_mean(name, names),
                 "every set is made of candidates", "add it to the candidates");
    if (!fixed.insert(name).second)
      issues.add({}, "the fixed sensor '" + name + "' is given twice", "", "give it once");
  }
  if (options.sensors < 1 || options.sensors > candidates.size())
    issues.add({}, std::to_string(options.sensors) + " sensors of " + std::to_string(candidates.size()) + " candidates",
               "the number of sensors must be from 1 to that of the candidates", "place fewer, or add candidates");
  else if (fixed.size() > options.sensors)
    issues.add({},
               std::to_string(fixed.size()) + " sensors are fixed, but " + std::to_string(options.sensors) +
                   " are to be placed",
               "fixed sensors count", "place at least as many");
}

void check_prior(const SensorPlacementOptions& options, IssueList& issues) {
  if (options.criterion == PlacementCriterion::mutual_information && options.prior_deviation.size() == 0)
    issues.add({}, "mutual information without a prior", "it is what the sensors add to what is known before",
               "give every parameter its prior deviation, or use D-optimality");
  if (options.prior_deviation.size() > 0 && !(options.prior_deviation.array() > 0.0).all())
    issues.add({}, "a prior deviation is not positive", "it is a standard deviation", "");
  if (options.scale.size() > 0 && !(options.scale.array() > 0.0 && options.scale.array().isFinite()).all())
    issues.add({}, "a parameter's scale is not positive", "information is compared in scaled parameters", "");
}

void check_sizes(const std::vector<SensorCandidate>& candidates, const SensorPlacementOptions& options,
                 IssueList& issues) {
  const auto& first = candidates.front().information;
  const Index n = first.empty() ? 0 : first.front().rows();
  for (const auto& candidate : candidates) {
    bool fits = !first.empty() && candidate.information.size() == first.size();
    for (const auto& each : candidate.information) fits = fits && each.rows() == n && each.cols() == n;
    if (!fits)
      issues.add({}, "the information of '" + candidate.name + "' has another size than that of the first candidate",
                 "it is one square matrix for each parameter value", "");
  }
  if ((options.scale.size() > 0 && options.scale.size() != n) ||
      (options.prior_deviation.size() > 0 && options.prior_deviation.size() != n))
    issues.add({}, "scales or prior deviations do not fit the parameters", "one each", "");
  for (const auto chosen : options.parameters)
    if (static_cast<Index>(chosen) >= n)
      issues.add({}, "a chosen parameter does not exist", "parameters count from 0", "");
}

Set places_of(const std::vector<std::string>& names, const std::vector<SensorCandidate>& candidates) {
  Set places;
  for (const auto& name : names)
    places.push_back(
        static_cast<std::size_t>(std::ranges::find(candidates, name, &SensorCandidate::name) - candidates.begin()));
  return places;
}

}  // namespace

double placement_criterion(const std::vector<MatrixXd>& information, const SensorPlacementOptions& options) {
  double sum = 0.0, worst = infinity;
  for (const auto& each : information) {
    const double criterion = criterion_of(each, options);
    sum += criterion;
    worst = std::min(worst, criterion);
  }
  return options.robustness == Robustness::mean ? sum / static_cast<double>(information.size()) : worst;
}

SensorPlacement place_sensors(const std::vector<SensorCandidate>& candidates, const SensorPlacementOptions& options) {
  IssueList issues;
  check_names(candidates, options, issues);
  check_prior(options, issues);
  if (!candidates.empty()) check_sizes(candidates, options, issues);
  issues.raise();
  const SetInformation sum = [&](const Set& set) -> std::optional<std::vector<MatrixXd>> {
    auto total = candidates[set.front()].information;
    for (std::size_t i = 1; i < set.size(); ++i)
      for (std::size_t j = 0; j < total.size(); ++j) total[j] += candidates[set[i]].information[j];
    return total;
  };
  return Search(candidates.size(), places_of(options.fixed, candidates), sum, options).run();
}

SensorPlacement place_sensors(const std::vector<SensorCandidate>& candidates, const SetInformation& information,
                              const SensorPlacementOptions& options) {
  IssueList issues;
  check_names(candidates, options, issues);
  check_prior(options, issues);
  issues.raise();
  return Search(candidates.size(), places_of(options.fixed, candidates), information, options).run();
}

}  // namespace kalfem
