// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/modal/modal_model_fit.hpp"
#include "kalfem/modal/modal_result.hpp"

namespace kalfem {

/// One pole of a fit as a mode, with covariances to first order. Its residues are R_oi = phi_o l_i: phi is R v with the
/// dominant right singular vector v of R (outputs x inputs), so that inputs count by how much they drive the mode.
/// Errors of FRFs are taken as independent of each other. `scale`: of the outputs.
IdentifiedMode mode_of_fit(const ModalModelFit& fit, Eigen::Index pole, Eigen::Index inputs,
                           const Eigen::VectorXd& scale);

/// Whether a pole's residues are more than noise: their squares by their covariance (Wald), chi-squared with two
/// degrees of freedom a response where there is no mode, exceed what one of `lines` places does by chance, at .1 %.
bool stands_out(const ModalModelFit& fit, Eigen::Index pole, Eigen::Index lines);

/// The peak of the first singular value of H (outputs x inputs) over the lines that is nearest to a mode, within its
/// half-power bandwidth or three lines, where its left singular vector has the shape (the complex mode indicator
/// function); nothing where there is none. `shape`: in scaled units.
std::optional<SpectralMode> indicated_mode(const FittedResponses& responses, const IdentifiedMode& mode,
                                           const Eigen::VectorXcd& shape);

}  // namespace kalfem
