// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/correlate.hpp"

#include "kalfem/api/modes_at_points.hpp"
#include "kalfem/api/structure_description.hpp"
#include "kalfem/identification/parameterised_structure.hpp"

namespace kalfem {

Correlation correlate(const Structure& structure, const MeasuredModes& modes, CorrelationOptions options) {
  const ParameterisedStructure parameterised(make_structure_model(structure.description()), {}, 0);
  const auto substructure = parameterised.model_of(modes.substructure);
  if (!substructure)
    throw InvalidInput("substructure '" + modes.substructure + "': there is none of that name", "", "");
  const LinearModel model = substructure->at(Eigen::VectorXd()).model;
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

}  // namespace kalfem
