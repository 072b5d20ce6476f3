// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

class InvalidInput;
class IssueList;

enum class ResponseQuantity { displacement, velocity, acceleration, strain };
enum class FrfInput { force, ground_displacement, ground_acceleration };

/// FRFs of one input: absolute motion of points, or strain at gauges, per force at a point [N], or per displacement or
/// acceleration of a ground.
struct FrfSet {
  FrfInput input = FrfInput::force;
  std::string place;                 ///< where the input acts: a degree of freedom, a point, or a ground
  std::vector<std::string> outputs;  ///< degrees of freedom or points; of strains gauges
  ResponseQuantity quantity = ResponseQuantity::acceleration;
};

/// " per force at 1".
std::string per_input(const FrfSet& set);
/// "(m/s^2)/N", of the FRFs of a set.
std::string unit_of(const FrfSet& set);
/// "acceleration".
std::string name_of(ResponseQuantity quantity);
/// q - p: the order of the output's time derivative less that of the ground motion's; both are 0 for displacements and
/// strains.
int derivative_order(const FrfSet& set);

/// Where the FRFs of a set act and are observed, in the degrees of freedom of a model.
struct FrfPlaces {
  Eigen::VectorXd force;    ///< unit force, n; empty for a ground
  Eigen::MatrixXd outputs;  ///< S^T, n x outputs
};
/// Adds unknown points, gauges and grounds, and grounds at which nothing ends to `issues`.
FrfPlaces places_of(const FrfSet& set, const LinearModel& model, IssueList& issues);

/// What to tell of a line [Hz] at which an undamped mode resonates, or the structure moves as a rigid body at 0 Hz.
InvalidInput singular_at(double frequency);

/// The ground of that name, which the model has.
const GroundCoupling& ground_of(const LinearModel& model, const std::string& name);

}  // namespace kalfem
