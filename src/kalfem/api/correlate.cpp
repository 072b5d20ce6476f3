// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/correlate.hpp"

#include "kalfem/api/modes_at_points.hpp"
#include "kalfem/api/responses_at_points.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/identification/parameterised_structure.hpp"

namespace kalfem {

namespace {

std::shared_ptr<const ParameterisedModel> substructure_of(const Structure& structure, const std::string& name) {
  const ParameterisedStructure parameterised(make_structure_model(structure.description()), {}, 0);
  auto substructure = parameterised.model_of(name);
  if (!substructure) throw InvalidInput("substructure '" + name + "': there is none of that name", "", "");
  return substructure;
}

}  // namespace

Correlation correlate(const Structure& structure, const MeasuredModes& modes, CorrelationOptions options) {
  const LinearModel model = substructure_of(structure, modes.substructure)->at(Eigen::VectorXd()).model;
  const auto measured = modes_at_points(modes, model);
  if (!modes.sensors.empty() && modes.sensors.size() != modes.points.size())
    throw InvalidInput("sensors: " + std::to_string(modes.sensors.size()) + " names, but there are " +
                           std::to_string(modes.points.size()) + " points",
                       "each point has one", "");
  std::vector<ShapeSensor> sensors;
  for (std::size_t i = 0; i < measured.points.size(); ++i)
    sensors.push_back(
        {modes.sensors.empty() ? modes.points[i] : modes.sensors[i], point_in(modes.substructure, modes.points[i])});
  options.above = modes.above;
  return correlate(measured.modes, measured.points, sensors, model, options);
}

std::vector<ResponseAgreement> correlate(const Structure& structure, const MeasuredResponses& responses) {
  const std::string substructure = split_point(responses.input).first;
  const FrfResidual residual(substructure_of(structure, substructure), {responses_at_points(responses)},
                             Eigen::VectorXd(), response_options(responses));
  return agreement_of(residual, Eigen::VectorXd());
}

}  // namespace kalfem
