// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// What a filter assumes of the structure's motion at a record's first sample.
struct RecordStart {
  bool moving = false;                        ///< unknown: about rest, with deviations of the record's size
  bool spiked = false;                        ///< one of the first values was taken for a spike and left out
  std::string reason = {};                    ///< in words
  double displacement = 0.0, velocity = 0.0;  ///< largest deviation of a degree of freedom [m], [m/s]
};

/// In a sentence.
std::string explain(const RecordStart& start);

/// Whether the case says where the structure starts, so that the record need not tell.
bool states_initial_motion(const EstimationSettings& settings);

/// Rest, where a filter that is sure of it can follow the record's first samples: their NIS is neither
/// significant (above the 1 - 1e-6 quantile of chi-squared) nor large (four per channel: twice the deviations), or no
/// innovation exceeds 0.3 of its channel's root mean square, as an error of the model may make it.
/// Inputs and the doubt about unknowns are in the NIS, so that a ground that jerks at once is no motion before. A spike
/// is no motion either: of five samples of a channel the one furthest from its prediction may be left out.
RecordStart start_by_first_samples(const AugmentedModel& augmented_model, const FilterInput& input,
                                   EstimationOptions options);

/// Gives the prior of a structure that already moves at the first sample deviations of the record's size: about rest,
///     Cov(z) = sum_r phi_r phi_r^T s_r^2 / w_r^4 + sum_i g_i g_i^T,   Cov(z') = sum_r phi_r phi_r^T s_r^2 / w_r^2 +
///     ...
/// phi_r and w_r: modes of the model with the connectors' secant stiffnesses at these deformations (statistical
/// linearisation, iterated). s_r: acceleration of a mode, twice that of the record below sqrt(2) w_r, as all modes of
/// the band would share it; displacements and velocities count by their derivatives. g_i: static response to known
/// input i, of its size below sqrt(2) w_r, with that of its rate for velocities. A mode slower than the record counts
/// as one period of it. Connectors' internal states: their size after a stroke to the deformation's deviation.
/// Correlated in the modes' shapes, because independent displacements of stiffly connected masses would be forces
/// beyond all measure. `inputs`: [r; r'; r''] at the samples. Nothing changes where no sensor sees a motion; then
/// false.
bool set_moving_start(const AugmentedModelSetup& setup, const Record& record, const Eigen::MatrixXd& inputs,
                      StatePrior& prior);

}  // namespace kalfem
