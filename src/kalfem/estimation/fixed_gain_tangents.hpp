// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "kalfem/estimation/fixed_gain.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {

/// The maps of an augmented model before the laws close them, and the parameters of these laws.
struct OpenModel {
  OpenMap process, measurement, monitored;
  std::vector<Eigen::VectorXd> laws;  ///< parameters of each connector
};

/// `input`: a record over which the model is to run. `monitored`: rows of the model's own system, or none.
OpenModel open_model(const AugmentedModel& augmented_model, const FilterInput& input, const OutputMap& monitored);

/// How a run of an augmented model over a record depends on a number c.
struct RunDerivative {
  Eigen::MatrixXd process = {}, measurement = {}, monitored = {};  ///< dOpenMap::all / dc; empty: none depends on c
  std::vector<std::pair<ParameterTarget, double>> laws = {};       ///< d(parameter) / dc, where it is not 0
  Eigen::MatrixXd measured = {};  ///< dy / dc of what the sensors recorded, channels x samples; empty: 0
  Eigen::MatrixXd inputs = {};    ///< d(FilterInput::inputs) / dc; empty: 0
};

/// Central difference of two models about `here`, `distance` in c apart. Nothing where they are not of one size.
std::optional<RunDerivative> central_difference(const OpenModel& here, const OpenModel& below, const OpenModel& above,
                                                double distance);

/// Whether run_tangents() knows the model: its linear part has no unknowns (ParameterTangent).
bool has_tangents(const AugmentedModel& augmented_model);

/// d/dc of everything that run_with_gains() gives, for many numbers c in one run that carries their tangents beside the
/// mean. With the model's Jacobians F and H at the mean,
///     T- = F T+ + df/dc,     D = dy/dc - H T- - dh/dc,     T+ = T- + K_k D,
/// T = dx/dc, n x numbers, and D the derivatives of the innovations; T = 0 at the start, whose prior does not depend on
/// c. Jacobians are those of the open maps, F = A + G J N, with J = df/dk of the closed connector forces f by central
/// differences at all points of a block of samples at once (1e-6 of the arguments' largest values: errors of about
/// 1e-10 where laws are smooth). df/dc is
///     dA x + dG f + dB u + G (J (dN x + dL f + dE u) + df/dparameter dparameter).
/// Each number costs two products of the size of a step, whatever it changes; docs/theory/tangents.md. `largest`: of
/// the process model's arguments along the run, FixedGainMeans::largest. `state_at`: as in run_with_gains(). Nothing
/// where a connector force cannot be evaluated.
std::optional<std::vector<FixedGainMeans>> run_tangents(const AugmentedModel& augmented_model, const FilterInput& input,
                                                        const Gains& gains, const OutputMap& monitored,
                                                        Eigen::Index state_at, const Eigen::VectorXd& largest,
                                                        const std::vector<RunDerivative>& numbers);

}  // namespace kalfem
