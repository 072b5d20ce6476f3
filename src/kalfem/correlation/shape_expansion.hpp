// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/correlation/expansion_method.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/updating/measured_mode.hpp"
#include "kalfem/updating/mode_pairing.hpp"

namespace kalfem {

/// How measured shapes differ from a model's: as an error of its stiffness lets them, and by noise.
///
/// To first order the true shape of mode i mixes those of the model [FK68],
///     u = a (phi_i + sum_j c_j phi_j),   c_j = phi_j^T dK phi_i / (lambda_i - lambda_j),
/// and where dK is random, of relative size tau, phi_j^T dK phi_i is of the size tau sqrt(lambda_i lambda_j): the c_j
/// are taken as normal, with the deviations of mixing_deviations(). The entries are y = P u + noise.
struct ModalMixing {
  double stiffness_error = 0.0;  ///< tau
  double noise = 1.0;            ///< of the entries, in their stated deviations
};

/// A measured shape at the degrees of freedom of the model.
struct ExpandedShape {
  std::size_t measured = 0;   ///< position in the list of measured modes
  Eigen::VectorXd shape;      ///< in the scale of the measured one
  Eigen::VectorXd deviation;  ///< standard deviation of each entry
  Eigen::VectorXd model;      ///< the paired mode of the model in the same scale
  double band = 0.0;          ///< size of the deviations against that of the shape, both as sqrt(sum m_kk u_k^2)
};

/// Measured shapes at all degrees of freedom, with what the model's error leaves open.
struct ShapeExpansion {
  ExpansionMethod method = ExpansionMethod::model;
  ModalMixing mixing = {};
  std::vector<ExpandedShape> shapes = {};  ///< of the measured shapes that have a pair
};

/// The three methods are linear in the measured entries, u = T y. With the truth of ModalMixing, whose tau and noise
/// all shapes together tell,
///     cov(u - truth) = a^2 (T P - 1) Phi E[c c^T] Phi^T (T P - 1)^T + T R T^T,
/// R being the covariance of the entries; ExpansionMethod::model is the T that makes it least. `serep` takes as many of
/// the paired modes as there are entries, those of the nearest frequencies first, weights entries by their errors, and
/// leaves out combinations of which the entries see less than a hundredth.
///
/// `modes`: elastic ones of the model, more than were measured; what still higher ones add to the truth is not in the
/// deviations. Throws InvalidInput where the dynamic stiffness is singular at a frequency.
ShapeExpansion expand_shapes(const std::vector<MeasuredMode>& measured, const std::vector<ModePair>& pairs,
                             const std::vector<DofCombination>& points, const LinearModel& model,
                             const NormalModes& modes, ExpansionMethod method);

}  // namespace kalfem
