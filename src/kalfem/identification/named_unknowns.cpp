// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/named_unknowns.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/likelihood_unknowns.hpp"
#include "kalfem/identification/released_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

using Kind = LikelihoodUnknownKind;

template <class T>
std::optional<std::size_t> place_of(const std::vector<T>& all, const std::string& name) {
  const auto found = std::ranges::find(all, name, &T::name);
  if (found == all.end()) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

std::vector<std::string> names_of(const EstimationProblem& problem) {
  std::vector<std::string> names;
  for (const auto& unknown : problem.settings.unknowns) names.push_back(unknown.name);
  for (const auto& unknown : problem.settings.likelihood_unknowns) names.push_back(unknown.name);
  for (const auto& offset : problem.offsets) names.push_back(offset.name);
  return names;
}

/// A drift has no single value.
void check_constant(const std::string& name, double random_walk, const SourceLocation& location, IssueList& issues) {
  if (random_walk > 0.0)
    issues.add(location, "'" + name + "' drifts with a random walk of " + shortest(random_walk),
               "a parameter of the likelihood is one number for the whole record",
               "set its random_walk to 0, or leave it to the filter");
}

bool is_of_finite_elements(const Parameter& parameter) {
  return std::holds_alternative<FiniteElementParameter>(parameter.where);
}

template <class T>
void drop(std::vector<T>& from, const std::vector<std::string>& names) {
  std::erase_if(from, [&](const T& each) { return std::ranges::find(names, each.name) != names.end(); });
}

}  // namespace

NamedUnknowns::NamedUnknowns(EstimationProblemPtr problem, std::vector<std::string> names,
                             const std::optional<VectorXd>& first)
    : problem_(std::move(problem)), names_(std::move(names)), remaining_(*problem_) {
  first_.resize(std::ssize(names_));
  find_places();
  if (first && first->size() != first_.size())
    throw InvalidInput(
        std::to_string(first->size()) + " first values for " + std::to_string(first_.size()) + " named unknowns",
        "there must be one each", "");
  if (first) first_ = *first;
  if (!admissible(first_))
    throw InvalidInput("a first value of the named unknowns is not possible",
                       "values are finite, a gain is not zero, and noise is positive", "start elsewhere");
  drop(remaining_.settings.unknowns, names_);
  drop(remaining_.offsets, names_);
  check_linear_part();
  reduce_finite_elements();
}

void NamedUnknowns::find_places() {
  IssueList issues;
  std::set<std::string> seen;
  const auto& [structure, sensors, offsets, rate, settings] = *problem_;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const std::string& name = names_[i];
    const auto at = static_cast<Index>(i);
    if (!seen.insert(name).second) issues.add({}, "the unknown '" + name + "' is named twice", "", "name it once");
    if (const auto place = place_of(settings.unknowns, name)) {
      const auto& unknown = settings.unknowns[*place];
      check_constant(name, unknown.random_walk, unknown.location, issues);
      for (const auto& target : unknown.targets) bindings_.push_back({at, target});
      first_[at] = unknown.initial;
    } else if (const auto without_state = place_of(settings.likelihood_unknowns, name)) {
      likelihood_unknowns_.push_back({at, *without_state});
      first_[at] = settings.likelihood_unknowns[*without_state].initial;
    } else if (const auto offset = place_of(offsets, name)) {
      check_constant(name, offsets[*offset].random_walk, {}, issues);
      offsets_.push_back({at, *offset});
      first_[at] = offsets[*offset].initial;
    } else {
      issues.add({}, "there is no unknown '" + name + "'" + did_you_mean(name, names_of(*problem_)),
                 "only an unknown of the estimation can be named", "add it to estimate.unknown");
    }
  }
  issues.raise();
}

/// The filter makes its linear part anew where it depends on its own unknowns, from finite elements as they were given.
void NamedUnknowns::check_linear_part() const {
  const auto named =
      std::ranges::find_if(bindings_, [](const auto& each) { return is_of_finite_elements(each.target); });
  if (named == bindings_.end()) return;
  const std::string& name = names_[static_cast<std::size_t>(named->index)];
  IssueList issues;
  for (const auto& unknown : remaining_.settings.unknowns)
    for (const auto& target : unknown.targets)
      if (!can_be_released(problem_->structure->parts, target)) {
        issues.add(unknown.location,
                   "'" + unknown.name + "' is left to the filter, while the finite elements' '" + name + "' is named",
                   "both are of the linear part, which is set as a whole",
                   "name '" + unknown.name + "' too, or neither");
        break;
      }
  issues.raise();
}

void NamedUnknowns::reduce_finite_elements() {
  std::vector<StructureBinding> own;
  for (const auto& binding : bindings_)
    if (is_of_finite_elements(binding.target)) own.push_back(binding);
  if (own.empty()) return;
  finite_elements_ = std::make_shared<const ParameterisedStructure>(problem_->structure, own, first_.size());
  reduced_ = finite_elements_->at(first_);
}

EstimationProblemPtr NamedUnknowns::problem_at(const VectorXd& theta) const {
  auto structure = std::make_shared<StructureModel>(*problem_->structure);
  if (finite_elements_) structure->parts.finite_elements = finite_elements_->near(reduced_, theta).finite_elements;
  for (const auto& [index, parameter] : bindings_) set_parameter(structure->parts, parameter, theta[index]);
  auto problem = std::make_shared<EstimationProblem>(remaining_);
  problem->structure = std::move(structure);
  return problem;
}

VectorXd NamedUnknowns::likelihood_values(const VectorXd& theta) const {
  const auto& unknowns = problem_->settings.likelihood_unknowns;
  VectorXd values(std::ssize(unknowns));
  for (std::size_t i = 0; i < unknowns.size(); ++i) values[static_cast<Index>(i)] = unknowns[i].initial;
  for (const auto& [of_theta, index] : likelihood_unknowns_) values[static_cast<Index>(index)] = theta[of_theta];
  return values;
}

void NamedUnknowns::subtract_offsets(const VectorXd& theta, Record& record) const {
  for (const auto& [of_theta, index] : offsets_)
    if (const Index row = record.find(problem_->offsets[index].sensor); row >= 0)
      record.values.row(row).array() -= theta[of_theta];
}

Record NamedUnknowns::as_recorded(const VectorXd& theta, Record ideal) const {
  for (const auto& offset : problem_->offsets)
    if (const Index row = ideal.find(offset.sensor); row >= 0) ideal.values.row(row).array() += offset.initial;
  for (const auto& [of_theta, index] : offsets_) {
    const auto& offset = problem_->offsets[index];
    if (const Index row = ideal.find(offset.sensor); row >= 0)
      ideal.values.row(row).array() += theta[of_theta] - offset.initial;
  }
  const auto& unknowns = problem_->settings.likelihood_unknowns;
  const VectorXd values = likelihood_values(theta);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const double value = values[static_cast<Index>(i)];
    for (const auto& sensor : unknowns[i].sensors) {
      const Index row = ideal.find(sensor);
      if (row < 0) continue;
      if (unknowns[i].kind == Kind::sensor_gain) ideal.values.row(row) *= value;
      if (unknowns[i].kind == Kind::sensor_noise) ideal.channels[static_cast<std::size_t>(row)].noise = value;
    }
  }
  return with_clocks(unknowns, values, std::move(ideal));
}

bool NamedUnknowns::admissible(const VectorXd& theta) const {
  const auto fits = [&](const Place& place) {
    const double value = theta[place.of_theta];
    switch (problem_->settings.likelihood_unknowns[place.index].kind) {
      case Kind::sensor_gain:
        return value != 0.0;
      case Kind::sensor_noise:
        return value > 0.0;
      case Kind::process_noise:
        return value >= 0.0;
      case Kind::sensor_drift:
        return value > -1.0;
      case Kind::sensor_delay:
        break;
    }
    return true;
  };
  return theta.allFinite() && std::ranges::all_of(likelihood_unknowns_, fits);
}

VectorXd NamedUnknowns::gains(const VectorXd& theta, const std::vector<Sensor>& sensors) const {
  const VectorXd values = likelihood_values(theta);
  const auto& unknowns = problem_->settings.likelihood_unknowns;
  VectorXd gains = VectorXd::Ones(std::ssize(sensors));
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (std::size_t j = 0; j < sensors.size(); ++j)
      if (unknowns[i].kind == Kind::sensor_gain && unknowns[i].is_of(sensors[j].name))
        gains[static_cast<Index>(j)] = values[static_cast<Index>(i)];
  return gains;
}

}  // namespace kalfem
