#pragma once

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/reduction/partition.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// M-orthonormal basis of what the columns span, n x at most their number. Directions of which less than a
/// hundred-thousandth of the columns' unit size is left beside the others are dropped.
Eigen::MatrixXd orthonormal(Eigen::MatrixXd columns, const Eigen::SparseMatrix<double>& mass);

/// Rayleigh-Ritz: the mass-normalised combinations of independent columns between which K and M have no coupling, and
/// their values [(rad/s)^2], ascending.
LowestModes uncoupled(Eigen::MatrixXd columns, const Eigen::SparseMatrix<double>& stiffness,
                      const Eigen::SparseMatrix<double>& mass);

/// sqrt(lambda) / 2 pi [Hz]; negative values count as 0.
Eigen::VectorXd natural_frequencies(const Eigen::VectorXd& values);

/// (A + A^T) / 2.
Eigen::MatrixXd symmetric(const Eigen::MatrixXd& matrix);

/// T = [I 0 0; Psi Phi_1 Phi_2], n x r, its rows in the order of the full model. The interior's shapes, of n_i rows
/// each, go over into T a few columns at a time and are never there twice.
Eigen::MatrixXd transformation(const Partition& parts, Eigen::MatrixXd static_part, Eigen::MatrixXd modes,
                               Eigen::MatrixXd further_modes = {});

/// T^T (C + C_m) T, r x r, without ever forming the modal damping C_m.
SparseMatrix projected_damping(const LinearModel& model, const Eigen::MatrixXd& T);

/// The model in the coordinates q of z = T q with T = [I 0; Psi Phi]: constraint modes Psi, in equilibrium in the
/// interior, and mass-normalised modes Phi of the interior with these values [(rad/s)^2]. So the last block of the mass
/// is the identity, that of the stiffness diagonal, and the stiffness has no coupling between the two. Grounds,
/// points and gauges are carried over; the damping holds C_m.
LinearModel projected_model(const LinearModel& model, const Eigen::MatrixXd& T, const Eigen::VectorXd& values,
                            std::vector<std::string> names);

/// Damping, grounds, points and gauges of the model in the coordinates q of z = T q; mass and stiffness stay empty.
LinearModel projected_surroundings(const LinearModel& model, const Eigen::MatrixXd& T, std::vector<std::string> names);

/// The boundary and what is kept beside it, each name once.
std::vector<std::string> joined(const std::vector<std::string>& boundary, const std::vector<std::string>& also_kept);

/// Band in which modes are compared [Hz]: what is asked for, or 0 for all kept modes (see ReductionOptions).
double comparison_band(const ReductionErrorIndicators& error_indicators, double asked);
/// Full and reduced modes up to a frequency [Hz], place by place, and their strains at the gauges: sets `modes` and
/// `gauges` of the indicators, the latter from the modes in the lower half. `whole`: factor of the full model's K, null
/// where it is not at hand.
void compare_modes(const LinearModel& full, const Superelement& reduced, double up_to, const StiffnessFactor* whole,
                   ReductionErrorIndicators& error_indicators);

}  // namespace kalfem
