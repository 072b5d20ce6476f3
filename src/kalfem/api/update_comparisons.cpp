// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/update_comparisons.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/api/filter_problem.hpp"
#include "kalfem/api/modes_at_points.hpp"
#include "kalfem/api/responses_at_points.hpp"
#include "kalfem/api/sensor_record.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/identification/simulation_residual.hpp"
#include "kalfem/updating/frf_residual.hpp"
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/static_residual.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Smoothing of frequency responses decreases to the first width divided by this number, then stops.
constexpr double smoothing_range = 10.0;

/// Makes the residual of each kind of comparison.
class ResidualMaker {
public:
  ResidualMaker(const Structure& structure, const StructurePtr& model,
                const std::shared_ptr<const ParameterisedStructure>& parameterised,
                const std::vector<UpdatingParameter>& parameters, const std::vector<StructureBinding>& connectors)
      : structure_(structure),
        model_(model),
        parameterised_(parameterised),
        parameters_(parameters),
        connectors_(connectors),
        start_(initial_values(parameters)) {}

  std::vector<ResidualPtr> operator()(const MeasuredModes& given) const {
    const auto substructure = substructure_of(given.substructure);
    auto measured = modes_at_points(given, substructure->at(start_).model);
    return {std::make_shared<ModalResidual>(substructure, std::move(measured.modes), std::move(measured.points), start_,
                                            ModalResidualOptions{.above = given.above})};
  }

  std::vector<ResidualPtr> operator()(const MeasuredResponses& given) const {
    const auto measured = responses_at_points(given);
    const auto substructure = substructure_of(split_point(given.input).first);
    auto options = response_options(given);
    const auto widths = given.smoothing > 0.0 ? smoothing_widths(given.smoothing, given.smoothing / smoothing_range)
                                              : std::vector<double>{0.0};
    std::vector<ResidualPtr> steps;
    for (const double width : widths) {
      options.smoothing = width;
      steps.push_back(std::make_shared<FrfResidual>(substructure, std::vector{measured}, start_, options));
    }
    return steps;
  }

  std::vector<ResidualPtr> operator()(const MeasuredDeflections& given) const {
    if (given.displacements.empty())
      throw InvalidInput("displacements: the list is empty", "there is nothing to compare with", "");
    const std::string name = split_point(given.displacements.front().first).first;
    const auto substructure = substructure_of(name);
    const LinearModel model = substructure->at(start_).model;
    StaticTest test{"deflections", {}, {}};
    for (const auto& [point, force] : given.forces)
      test.forces.push_back({combination_of(model, point_in(name, point)), force});
    for (const auto& [point, value] : given.displacements)
      test.displacements.push_back({combination_of(model, point_in(name, point)), value, given.std});
    return {std::make_shared<StaticResidual>(substructure, std::vector{test}, start_)};
  }

  std::vector<ResidualPtr> operator()(const MeasuredRecord& given) const {
    require_signals(structure_.description());
    require_channels(given.record, given.sensors);
    if (given.substeps < 1)
      throw InvalidInput("substeps: " + std::to_string(given.substeps), "a sample interval has at least one", "");
    const double length = given.record.end() - given.record.start;
    if (!(given.settle >= 0.0) || !(given.settle < length))
      throw InvalidInput(
          "settle: it is " + shortest(given.settle) + " s, but the record is " + shortest(length) + " s long",
          "what follows is compared", "give a shorter time, >= 0");
    const auto sensors = make_filter_problem(structure_, given.record.sample_rate, {.sensors = given.sensors}).problem;
    return {std::make_shared<SimulationResidual>(
        model_, sensors->sensors, record_of_sensors(given.record, given.sensors), parameterised_, parameters_,
        SimulationResidual::Options{
            .name = "record", .settle = given.settle, .substeps = given.substeps, .connectors = connectors_})};
  }

private:
  [[nodiscard]] std::shared_ptr<const ParameterisedModel> substructure_of(const std::string& name) const {
    auto found = parameterised_->model_of(name);
    if (!found) throw InvalidInput("substructure '" + name + "': there is none of that name", "", "");
    return found;
  }

  const Structure& structure_;
  const StructurePtr& model_;
  const std::shared_ptr<const ParameterisedStructure>& parameterised_;
  const std::vector<UpdatingParameter>& parameters_;
  const std::vector<StructureBinding>& connectors_;
  VectorXd start_;
};

}  // namespace

std::vector<MadeComparison> make_comparisons(const Structure& structure, const StructurePtr& model,
                                             const std::shared_ptr<const ParameterisedStructure>& parameterised,
                                             const std::vector<UpdatingParameter>& parameters,
                                             const UpdateOptions& options,
                                             const std::vector<StructureBinding>& connectors) {
  const ResidualMaker make(structure, model, parameterised, parameters, connectors);
  std::vector<MadeComparison> made;
  IssueList issues;
  const auto add = [&](const std::string& place, const UpdateComparison& given) {
    try {
      if (!(given.weight > 0.0) || !std::isfinite(given.weight))
        throw InvalidInput("weight: it is " + shortest(given.weight), "it must be > 0", "");
      made.push_back({given.name, std::visit(make, given.what), given.weight});
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues()) issues.add({}, place + issue.what, issue.why, issue.fix);
    }
  };
  if (!options.frequencies.empty() || options.comparisons.empty())
    add("", {.name = "frequencies",
             .what = MeasuredModes{
                 .substructure = options.substructure, .frequencies = options.frequencies, .above = options.above}});
  for (std::size_t i = 0; i < options.comparisons.size(); ++i)
    add("comparisons[" + std::to_string(i) + "] '" + options.comparisons[i].name + "': ", options.comparisons[i]);
  issues.raise();
  return made;
}

}  // namespace kalfem
