// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/study/study.hpp"
#include "kalfem/updating/considered.hpp"

namespace kalfem {

struct CaseStudy;

/// The case's structural modifications with their names looked up. Problems go to `issues` with their place.
std::vector<StructuralModification> make_modifications(const CaseStudy& study, IssueList& issues);

/// For reports: the errors that the standard deviations of predicted frequencies leave out.
inline constexpr const char* deviations_leave_out =
    "The standard deviations are propagated from those of the updated parameters and of numbers that `known_to` "
    "states, "
    "to first order. They do not include errors of other numbers and of the model's form, of the values that the "
    "modification sets, or of the positions of its masses.";

/// Natural frequencies of the updated structure after a change.
struct StructuralModificationResult {
  std::string name, substructure;
  Eigen::VectorXd frequencies;  ///< [Hz]
  /// Standard deviations of `frequencies` [Hz] due to the updated parameters and to stated numbers, see
  /// predict_modifications(). Infinite if the measurements do not determine a parameter on which the frequency depends.
  /// Empty without an updating.
  Eigen::VectorXd deviations;
  Eigen::VectorXd considered;  ///< the part of stated numbers; empty where nothing is stated
};

/// What several models predict of a modification, each with its weight, as one prediction: mode by mode in the order of
/// frequency,
///     f = sum w_m f_m,   std^2 = sum w_m (std_m^2 + (f_m - f)^2).
StructuralModificationResult mixed(const std::vector<StructuralModificationResult>& models,
                                   const Eigen::VectorXd& weights);

/// Result of an updating.
struct UpdatedParameters {
  Eigen::VectorXd values;
  ParameterStatistics statistics;
  std::optional<Considered> considered = {};  ///< what the plan's stated numbers do to them
};

/// Predicts the natural frequencies of each modification, starting from the updated structure if `updating` is given.
/// Throws InvalidInput for parameters that the substructure does not have.
///
/// With the covariance S of the updated parameters theta, to first order,
///   std(f_j)^2 = g_j^T S g_j,    g_jp = phi_j^T (dK/dtheta_p - lambda_j dM/dtheta_p) phi_j / (8 pi^2 f_j),
/// with the modes of the modified structure [FK68]. A stated number c_i, to which the parameters are fitted, adds
///   (g_ji + sum_p g_jp dtheta_p/dc_i)^2 sigma_i^2.
/// A parameter that the modification sets has no uncertainty.
std::vector<StructuralModificationResult> predict_modifications(const Study& study,
                                                                const std::optional<UpdatedParameters>& updating);

}  // namespace kalfem
