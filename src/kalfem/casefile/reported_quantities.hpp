#pragma once

#include <vector>

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// What is reported of a model: displacement, velocity and acceleration of its reported points, then deformation, rate
/// and force of its connectors.
std::vector<OutputDescription> reported_quantities(const CoupledModel& model);

/// The quantity of that point or connector, nullptr where it is not among them.
const PointQuantity* find_quantity(const std::vector<PointQuantity>& quantities, const std::string& point,
                                   ObservedQuantity quantity);

/// Sets the truth and the error against it after settling.
void set_truth(PointQuantity& quantity, Eigen::VectorXd truth, Eigen::Index settled);

}  // namespace kalfem
