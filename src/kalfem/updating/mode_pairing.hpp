// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Displacements of measured points from those of the degrees of freedom, points x n. A point is a sum of coefficient
/// times degree of freedom or named point of the model.
/// Throws InvalidInput with every name that the model does not have.
SparseMatrix point_rows(const LinearModel& model, const std::vector<DofCombination>& points);

/// Modal assurance criterion between all columns a_i of `one` and b_j of `other`,
///     (a_i^T W b_j)^2 / (a_i^T W a_i  b_j^T W b_j) in [0, 1] [All03],
/// with W the weight (the mass matrix) or 1 where none is given; 0 for a column without motion.
Eigen::MatrixXd mac_matrix(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other,
                           const SparseMatrix* weight = nullptr);

/// The same of complex shapes, |a_i^H b_j|^2 / (a_i^H a_i  b_j^H b_j).
Eigen::MatrixXd complex_mac_matrix(const Eigen::MatrixXcd& one, const Eigen::MatrixXcd& other);

/// The combination A c of a group's shapes that is nearest to a target t in the norm of W: of one shape, its modal
/// scale factor; of several, what a repeated eigenvalue may show as.
struct SubspaceFit {
  Eigen::VectorXd coefficients;  ///< c = (A^T W A)^+ A^T W t
  double mac = 0.0;              ///< of A c and t: the squared cosine of the angle between t and the space
};
/// From the products A^T W A (g x g), A^T W t and t^T W t.
SubspaceFit fit_in_subspace(const Eigen::MatrixXd& gram, const Eigen::VectorXd& toward, double target_squared);

/// The assignment of rows to columns with the largest sum of gains, each column used once at most and each pair only
/// where its gain is positive: the Hungarian method [Kuh55] by shortest augmenting paths [JV87]. Per row its column or
/// nothing.
std::vector<std::optional<Eigen::Index>> best_assignment(const Eigen::MatrixXd& gains);

struct ModePairingOptions {
  double least_mac = 0.5;         ///< below it a measured mode pairs with nothing
  double frequency_weight = 0.2;  ///< of the closeness in frequency, beside the MAC's 1
  double frequency_spread = 0.2;  ///< difference in ln f at which the closeness falls to 1/e
};

/// What a measured mode pairs with.
struct ModePair {
  std::optional<Eigen::Index> model;  ///< nothing where no mode agrees
  double mac = 0.0;                   ///< of the pair; where there is none, the best there is
  double frequency_difference = 0.0;  ///< f_model / f_measured - 1 of the pair, else of the model's nearest mode
};

/// Pairs that maximise sum [MAC + w exp(-(ln(f_model / f_measured) / spread)^2)] over pairs of a MAC of least_mac and
/// more: modes may cross, be missing in the model or be spurious in the measurement. `mac` is measured x model.
std::vector<ModePair> pair_modes(const Eigen::MatrixXd& mac, const Eigen::VectorXd& measured_frequencies,
                                 const Eigen::VectorXd& model_frequencies, const ModePairingOptions& options = {});

}  // namespace kalfem
