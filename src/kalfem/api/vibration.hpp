// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/api/sensors.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/base/progress.hpp"
#include "kalfem/vibration/computed_response.hpp"

namespace kalfem {

/// Free vibration of a structure about rest.
struct StructureModes {
  std::vector<std::string> dofs;  ///< of the rows of the shapes: "body.1"
  Eigen::VectorXd frequencies;    ///< undamped [Hz], ascending; rigid-body modes are 0
  Eigen::VectorXd damping;        ///< phi^T C phi / (2 omega), ratio to critical; 0 for rigid-body modes
  Eigen::MatrixXd shapes;         ///< dofs x modes, phi^T M phi = 1
};

/// The lowest modes of the whole structure, its connectors linear about rest and its grounds held. Finite elements are
/// as they are described: reduced or full. `count` 0: all, of at most 1000 degrees of freedom. Throws InvalidInput
/// where the structure does not fit or a connector has no tangent at rest.
StructureModes modes(const Structure& structure, Eigen::Index count = 0);

/// The modes of one substructure alone, without connectors; its own grounds are held. Throws InvalidInput if there is
/// none of that name.
StructureModes modes_of(const Structure& structure, const std::string& substructure, Eigen::Index count = 0);

/// Frequency responses H(f) of the structure, linear about rest, with motions exp(+i 2 pi f t): lines x outputs.
/// `input`: a force or a moved ground of the structure by its name, or a point at which a unit force acts. `outputs`:
/// absolute motions of points, acceleration("body.3"), and strains of gauges, strain("frame.g1"), per newton or per
/// metre of the ground. Throws InvalidInput for unknown names, outputs of connectors, and frequencies that are
/// negative, not finite or those of an undamped resonance.
Eigen::MatrixXcd frequency_responses(const Structure& structure, const Eigen::VectorXd& frequencies,
                                     const std::string& input, const std::vector<OutputDescription>& outputs);

/// Frequency responses of a structure with its finite elements at full order, as reduce() describes them, or both.
struct FrequencyResponseOptions {
  Eigen::VectorXd frequencies;             ///< [Hz], ascending
  std::vector<std::string> inputs;         ///< forces, moved grounds, or points at which unit forces act
  std::vector<OutputDescription> outputs;  ///< absolute motions of points and strains of gauges
  ResponseModel model = ResponseModel::full;
  ResponseMethod method = ResponseMethod::modal;
  Progress progress = {};
};

/// Every response with its peaks, and where both models are asked for, how far the reduced one is from the full one:
/// what `frf` of a case gives. A superelement keeps the points at which forces act beside its boundary, so that the
/// static response to them is exact. Throws InvalidInput as above, with every argument that is wrong.
FrequencyResponses frequency_responses(const Structure& structure, const FrequencyResponseOptions& options);

}  // namespace kalfem
