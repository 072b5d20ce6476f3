// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/place.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/stated_unknowns.hpp"
#include "kalfem/identification/unknown_prior.hpp"
#include "kalfem/placement/placement.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

constexpr std::size_t fewest_ranked = 1'000, most_ranked = 100'000;

/// The names in this order, each once; what is not among `all` is an issue.
std::vector<std::string> known_names(const char* list, const std::vector<std::string>& given,
                                     const std::vector<std::string>& all, IssueList& issues) {
  std::vector<std::string> names;
  for (const auto& name : given) {
    if (std::ranges::find(all, name) == all.end())
      issues.add({}, std::string(list) + ": there is no '" + name + "'" + did_you_mean(name, all), "", "");
    else if (std::ranges::find(names, name) == names.end())
      names.push_back(name);
  }
  return names;
}

template <class T>
std::vector<std::string> names_of(const std::vector<T>& all) {
  std::vector<std::string> names;
  for (const auto& each : all) names.push_back(each.name);
  return names;
}

void check(const PlaceOptions& options, IssueList& issues) {
  if (!(options.duration > 0.0) || !std::isfinite(options.duration))
    issues.add({}, "duration: it is " + shortest(options.duration) + " s", "the expected record needs a length > 0",
               "");
  refuse_measurement_unknowns(options.unknowns, issues);
  if (options.unknowns.empty())
    issues.add({}, "unknowns: the list is empty", "sensors are placed where they tell most of the unknowns",
               "give at least one");
  if (options.draws < 1) issues.add({}, "draws: " + std::to_string(options.draws), "there is at least one", "");
  const auto free = std::ssize(options.candidates) - std::ssize(options.keep);
  if (options.count < 1 || options.count > free)
    issues.add({},
               "count: " + std::to_string(options.count) + " sensors are to be placed, but there are " +
                   std::to_string(free) + " candidates" + (options.keep.empty() ? "" : " beside those of `keep`"),
               "each sensor needs a place of its own", "place from 1 to that many");
}

/// The candidates, those that stay first.
std::vector<CandidateSensor> ordered(const EstimationProblem& problem, const std::vector<std::string>& kept) {
  std::vector<CandidateSensor> candidates;
  for (const auto& sensor : problem.sensors) candidates.push_back({sensor.name, {sensor}});
  std::ranges::stable_partition(
      candidates, [&](const CandidateSensor& each) { return std::ranges::find(kept, each.name) != kept.end(); });
  return candidates;
}

/// The unknowns that do not drift: first those that count; `given`: the caller's own.
void set_unknowns(const std::vector<std::string>& counted, std::size_t given, PlacementProblem& placement,
                  IssueList& issues) {
  const auto& unknowns = placement.problem->settings.unknowns;
  placement.unknowns = counted;
  for (const auto& unknown : unknowns) {
    const bool counts = std::ranges::find(counted, unknown.name) != counted.end();
    if (unknown.random_walk > 0.0 && counts && counted.size() < given)
      issues.add({}, "parameters: '" + unknown.name + "' has a random walk", "sensors are placed for constant unknowns",
                 "leave it out");
    if (unknown.random_walk == 0.0 && !counts) placement.unknowns.push_back(unknown.name);
  }
  if (counted.size() == given)
    std::erase_if(placement.unknowns, [&](const std::string& name) {
      return std::ranges::find(unknowns, name, &Unknown::name)->random_walk > 0.0;
    });
  placement.counted = std::min(counted.size(), placement.unknowns.size());
  if (placement.counted == 0) issues.add({}, "unknowns: none is constant", "sensors are placed for constant ones", "");
  Named<MarginalPrior> priors;
  placement.initial.resize(static_cast<Index>(placement.unknowns.size()));
  for (const auto& name : placement.unknowns) {
    const auto& unknown = *std::ranges::find(unknowns, name, &Unknown::name);
    placement.initial[static_cast<Index>(priors.size())] = unknown.initial;
    placement.units.push_back(unknown.unit());
    priors.emplace_back(name, prior_of(unknown));
  }
  issues.raise();
  placement.prior = JointPrior(std::move(priors));
}

/// The question in the library's own types.
PlacementProblem problem_of(const Structure& structure, const PlaceOptions& options) {
  IssueList issues;
  require_signals(structure.description());
  check(options, issues);
  const auto kept = known_names("keep", options.keep, names_of(options.candidates), issues);
  auto counted = known_names("parameters", options.parameters, names_of(options.unknowns), issues);
  if (options.parameters.empty()) counted = names_of(options.unknowns);
  issues.raise();
  const auto made = make_filter_problem(structure, options.sample_rate,
                                        {.sensors = options.candidates,
                                         .unknowns = options.unknowns,
                                         .process_noise = options.process_noise,
                                         .threads = options.threads,
                                         .known_to = options.known_to});
  const StatedUnknowns stated = with_stated_unknowns(made.problem, made.setup);
  PlacementProblem placement{.problem = stated.problem, .candidates = ordered(*made.problem, kept)};
  placement.not_counted = stated.of_signals();
  check_excitation_is_known(*made.problem, issues);
  set_unknowns(counted, options.unknowns.size(), placement, issues);
  auto& choice = placement.options;
  choice.fixed = kept;
  choice.sensors = kept.size() + static_cast<std::size_t>(options.count);
  choice.criterion = options.criterion;
  choice.scale = choice.prior_deviation = placement.prior.deviation().head(static_cast<Index>(placement.counted));
  choice.most_sets = options.most_sets;
  choice.ranked = std::clamp(static_cast<std::size_t>(options.most_sets), fewest_ranked, most_ranked);
  choice.threads = options.threads;
  placement.draws = options.draws;
  placement.seed = options.seed;
  placement.drive.sample_rate = options.sample_rate;
  placement.drive.values.resize(0, std::lround(options.duration * options.sample_rate) + 1);
  return placement;
}

SensorSet set_of(const SensorChoice& found, const PlacedSet& set, Eigen::VectorXd by_filter = {}) {
  return {found.names(set), set.rank, set.criterion, set.bound, std::move(by_filter)};
}

}  // namespace

PlaceResult place(const Structure& structure, const PlaceOptions& options) {
  const SensorChoice found = place(problem_of(structure, options), options.progress);
  if (!found.failure.empty())
    throw InvalidInput(found.failure, "the choice rests on simulations", "look at the initial values of the unknowns");
  PlaceResult result{.parameters = found.parameters,
                     .units = found.units,
                     .prior = found.prior,
                     .remarks = found.remarks,
                     .tried = found.placement.tried,
                     .exact = found.placement.exact};
  for (const auto& set : found.best) result.best.push_back(set_of(found, set));
  for (const auto& [set, filter] : found.checked) result.checked.push_back(set_of(found, set, filter));
  for (const auto& each : found.candidates)
    result.candidates.push_back({each.name, each.kept, each.moves, each.rank, each.left});
  return result;
}

}  // namespace kalfem
