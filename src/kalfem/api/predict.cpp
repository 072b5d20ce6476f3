// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/predict.hpp"

#include <algorithm>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/measurement_unknowns.hpp"
#include "kalfem/vibration/driven_motion.hpp"

namespace kalfem {

using Eigen::VectorXd;

namespace {

using Kept = std::vector<EstimatedQuantity>;

/// The structure at the estimates. Unknowns that share a value set all of their parameters.
Structure at_estimates(const Structure& structure, const EstimateOptions& options, const EstimateResult& estimate) {
  NamedValues values;
  for (const auto& [name, prior] : options.unknowns) {
    if (is_measurement_unknown(name)) continue;
    const double found = estimate.parameter(name).mean;
    if (prior.applies_to.empty()) values.emplace_back(name, found);
    for (const auto& target : prior.applies_to) values.emplace_back(target, found);
  }
  return structure.at(values);
}

/// Parts and inputs of a structure, coupled.
std::shared_ptr<const CoupledModel> coupled(const StructureModel& structure) {
  return std::make_shared<const CoupledModel>(couple(structure.parts));
}

/// Throws InvalidInput with every argument that is wrong; what remains is found where the filter's model is made.
void check(const StructureModel& structure, const CoupledModel& model, const PredictOptions& options) {
  IssueList issues;
  if (options.steps < 1)
    issues.add({}, "steps: " + std::to_string(options.steps), "a sample interval has at least one", "");
  std::vector<std::string> known;
  for (const auto& part : model.substructures()) known.push_back(part.name);
  if (std::ranges::find(known, options.substructure) == known.end())
    issues.add({},
               "substructure: there is no '" + options.substructure + "'" + did_you_mean(options.substructure, known),
               "", "name a substructure");
  issues.raise();
  try {
    static_cast<void>(driving_points(structure, model, options.substructure));
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues()) issues.add({}, "substructure: " + issue.what, issue.why, issue.fix);
    issues.raise();
  }
}

const VectorXd* found_in(const Kept& all, const std::string& name) {
  const auto found = std::ranges::find(all, name, &EstimatedQuantity::name);
  return found == all.end() ? nullptr : &found->mean;
}

std::string name_of(ObservedQuantity quantity) {
  return quantity == ObservedQuantity::displacement ? "displacement"
         : quantity == ObservedQuantity::velocity   ? "velocity"
                                                    : "acceleration";
}

/// Estimates, with the accelerations that drive the substructure as further outputs, which go to `accelerations`.
EstimateResult estimate_with(const Structure& structure, const Record& record, EstimateOptions options,
                             const std::vector<std::string>& points, Kept& accelerations) {
  const std::size_t own = options.outputs.size();
  for (const auto& point : points) options.outputs.push_back({point + ".acceleration", acceleration(point)});
  EstimateResult result = estimate(structure, record, options);
  accelerations.assign(result.outputs.begin() + static_cast<std::ptrdiff_t>(own), result.outputs.end());
  result.outputs.resize(own);
  return result;
}

}  // namespace

const PredictedQuantity& PredictResult::at(const std::string& place, ObservedQuantity quantity) const {
  std::vector<std::string> known;
  for (const auto& each : predicted) {
    if (each.place == place && each.quantity == quantity) return each;
    known.push_back(each.place);
  }
  throw InvalidInput("the prediction has no such quantity of '" + place + "'" + did_you_mean(place, known), "", "");
}

PredictResult predict(const Structure& structure, const Record& record, const PredictOptions& options) {
  require_signals(structure.description());
  const auto given = make_structure_model(structure.description());
  const auto model = coupled(*given);
  check(*given, *model, options);
  Kept accelerations;
  PredictResult result{.estimate = estimate_with(structure, record, options.estimate,
                                                 driving_points(*given, *model, options.substructure), accelerations),
                       .predicted = {},
                       .failure = {}};
  const auto& estimate = result.estimate;
  if (estimate.failure) {
    result.failure = "the filter stopped, so there is nothing to predict from: " + estimate.failure->reason;
    return result;
  }
  StructurePtr moved;
  try {
    moved = make_structure_model(at_estimates(structure, options.estimate, estimate).description());
  } catch (const InvalidInput& error) {
    result.failure =
        "the estimates are physically impossible, so there is nothing to predict from: " + error.issues().front().what;
    return result;
  }
  const auto estimated = [&](const std::string& point, ObservedQuantity quantity) {
    const std::string name = point + "." + name_of(quantity);
    return quantity == ObservedQuantity::acceleration ? found_in(accelerations, name) : found_in(estimate.states, name);
  };
  for (auto& [place, quantity, values] : predict({.structure = moved,
                                         .model = coupled(*moved),
                                         .substructure = options.substructure,
                                         .estimated = estimated,
                                         .start = record.start,
                                         .sample_rate = record.sample_rate,
                                         .samples = record.samples(),
                                         .substeps = options.steps},
                                                 options.estimate.progress))
    result.predicted.push_back({place, unit_of(quantity), quantity, std::move(values)});
  return result;
}

}  // namespace kalfem
