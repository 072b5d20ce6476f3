#include "kalfem/prediction/base_driven.hpp"

#include <algorithm>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/first_order_hold.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Factor of K_ii, after checking that holding the boundary holds the interior.
Eigen::LDLT<MatrixXd> factor_interior(const MatrixXd& stiffness, const LinearModel& model,
                                      const std::vector<Index>& interior) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(stiffness);
  const VectorXd& values = eigen.eigenvalues();
  if (values[0] <= 1e-12 * values[values.size() - 1]) {
    Index free = 0;
    eigen.eigenvectors().col(0).cwiseAbs().maxCoeff(&free);
    throw InvalidInput("with its boundary held, the substructure still moves freely at '" +
                           model.dofs[static_cast<std::size_t>(interior[static_cast<std::size_t>(free)])] + "'",
                       "its motion does not follow from the boundary's", "join every part to the boundary by springs");
  }
  return Eigen::LDLT<MatrixXd>(stiffness);
}

}  // namespace

BaseDrivenSubstructure::BaseDrivenSubstructure(const LinearModel& model, std::vector<Index> boundary)
    : boundary_(std::move(boundary)) {
  for (Index i = 0; i < model.size(); ++i)
    if (std::ranges::find(boundary_, i) == boundary_.end()) interior_.push_back(i);
  if (boundary_.empty() || interior_.empty())
    throw InvalidInput(boundary_.empty() ? "no connector touches the substructure that is to be predicted"
                                         : "the substructure that is to be predicted has no degree of freedom beside "
                                           "those of its connectors",
                       "the prediction drives the interior by the boundary", "predict another substructure");
  const MatrixXd mass(model.mass), damping(model.damping), stiffness(model.stiffness);
  const auto n_i = static_cast<Index>(interior_.size()), n_b = static_cast<Index>(boundary_.size());
  const MatrixXd interior_stiffness = stiffness(interior_, interior_), interior_mass = mass(interior_, interior_);
  static_modes_ = -factor_interior(interior_stiffness, model, interior_).solve(stiffness(interior_, boundary_).eval());

  const Eigen::LDLT<MatrixXd> mass_factor(interior_mass);
  dynamics_ = MatrixXd::Zero(2 * n_i, 2 * n_i);
  dynamics_.topRightCorner(n_i, n_i).setIdentity();
  dynamics_.bottomLeftCorner(n_i, n_i) = -mass_factor.solve(interior_stiffness);
  dynamics_.bottomRightCorner(n_i, n_i) = -mass_factor.solve(damping(interior_, interior_).eval());
  drive_ = MatrixXd::Zero(2 * n_i, 2 * n_b + n_i);
  drive_.bottomRows(n_i) << -mass_factor.solve(interior_mass * static_modes_ + mass(interior_, boundary_)),
      -mass_factor.solve(damping(interior_, interior_) * static_modes_ + damping(interior_, boundary_)),
      mass_factor.solve(MatrixXd::Identity(n_i, n_i));
}

PredictedMotion BaseDrivenSubstructure::predict(const BoundaryMotion& boundary, const MatrixXd& applied,
                                                const VectorXd& start, const VectorXd& start_rate,
                                                double sample_rate) const {
  const auto n_i = static_cast<Index>(interior_.size()), n_b = static_cast<Index>(boundary_.size());
  const Index samples = boundary.acceleration.cols();
  MatrixXd inputs = MatrixXd::Zero(2 * n_b + n_i, samples);
  inputs.topRows(n_b) = boundary.acceleration;
  inputs.middleRows(n_b, n_b) = boundary.velocity;
  if (applied.size() > 0) inputs.bottomRows(n_i) = applied(interior_, Eigen::all);

  MatrixXd relative(2 * n_i, samples);
  relative.col(0) << start(interior_) - static_modes_ * boundary.displacement.col(0),
      start_rate(interior_) - static_modes_ * boundary.velocity.col(0);
  const auto hold = first_order_hold(dynamics_, drive_, 1.0 / sample_rate);
  for (Index k = 1; k < samples; ++k)
    relative.col(k) =
        hold.transition * relative.col(k - 1) + hold.begin_weight * inputs.col(k - 1) + hold.end_weight * inputs.col(k);

  const Index n = n_i + n_b;
  PredictedMotion motion{MatrixXd(n, samples), MatrixXd(n, samples), MatrixXd(n, samples)};
  motion.displacement(boundary_, Eigen::all) = boundary.displacement;
  motion.velocity(boundary_, Eigen::all) = boundary.velocity;
  motion.acceleration(boundary_, Eigen::all) = boundary.acceleration;
  motion.displacement(interior_, Eigen::all) = static_modes_ * boundary.displacement + relative.topRows(n_i);
  motion.velocity(interior_, Eigen::all) = static_modes_ * boundary.velocity + relative.bottomRows(n_i);
  motion.acceleration(interior_, Eigen::all) =
      static_modes_ * boundary.acceleration + dynamics_.bottomRows(n_i) * relative + drive_.bottomRows(n_i) * inputs;
  return motion;
}

}  // namespace kalfem
