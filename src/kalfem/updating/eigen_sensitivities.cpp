// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/eigen_sensitivities.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double equal_rates = 1e-8;  ///< relative to the largest: the eigenvectors that belong to them are arbitrary
/// Curvature by K - lambda M against that by K + s M, below which a mode of the group is not among the computed ones.
constexpr double least_curvature = 1e-9;
constexpr double rotation_end = 1e-14;
constexpr int most_sweeps = 60;

// d(lambda) of a group: eigenvalues of Phi_G^T (dK - lambda dM) Phi_G [FK68]. d(Phi_G) has a part in the computed
// modes, by modal superposition, and a part M-orthogonal to them, from (K - lambda M) X = F, singular only in the
// group: solved in the complement by conjugate gradients with the factor of K + s M as preconditioner [Alv97].
/// A matrix that does not depend on the parameter is 0 x 0.
MatrixXd times(const SparseMatrix& matrix, const MatrixXd& vectors) {
  return matrix.rows() == 0 ? MatrixXd::Zero(vectors.rows(), vectors.cols()) : MatrixXd(matrix * vectors);
}

double group_value(const LowestModes& modes, const ModeGroup& group) {
  return modes.values.segment(group.first, group.size).mean();
}

auto group_vectors(const LowestModes& modes, const ModeGroup& group) {
  return modes.vectors.middleCols(group.first, group.size);
}

/// (dK - lambda dM) Phi_G
MatrixXd unbalance(const LowestModes& modes, const ModeGroup& group, const ModelDerivative& derivative) {
  const MatrixXd shapes = group_vectors(modes, group);
  return times(derivative.stiffness, shapes) - group_value(modes, group) * times(derivative.mass, shapes);
}

VectorXd column_products(const MatrixXd& a, const MatrixXd& b) { return a.cwiseProduct(b).colwise().sum().transpose(); }

/// The space that is M-orthogonal to all computed modes, with conjugate gradients in it.
class Complement {
public:
  explicit Complement(const SolvedEigenproblem& problem)
      : problem_(problem), massed_(problem.mass * problem.modes.vectors) {}

  // Conjugate gradients on the complement of the computed modes, where K - lambda M is positive definite as long as
  // every mode below lambda is among them. A curvature near zero shows that one is not: then there is no answer.
  /// (K - lambda M) X = F - M Phi Phi^T F with Phi^T M X = 0.
  [[nodiscard]] std::optional<MatrixXd> solve(double lambda, const MatrixXd& forces,
                                              const EigenSensitivityOptions& options) const {
    MatrixXd direction = problem_.shifted.factor.solve(forces);
    const VectorXd end = options.tolerance * options.tolerance * column_products(forces, direction);
    MatrixXd residual = forces - massed_ * (problem_.modes.vectors.transpose() * forces);
    project(direction);
    VectorXd energy = column_products(residual, direction);
    MatrixXd solution = MatrixXd::Zero(forces.rows(), forces.cols());
    for (int i = 0; i < options.most_iterations && (energy.array() > end.array()).any(); ++i) {
      const MatrixXd massed = problem_.mass * direction;
      const MatrixXd image = problem_.stiffness * direction - lambda * massed;
      const VectorXd curvature = column_products(direction, image);
      const VectorXd size = curvature + (lambda + problem_.shifted.shift) * column_products(direction, massed);
      VectorXd step = VectorXd::Zero(energy.size());
      for (Index j = 0; j < energy.size(); ++j) {
        if (energy[j] <= end[j]) continue;
        if (!(curvature[j] > least_curvature * size[j])) return {};
        step[j] = energy[j] / curvature[j];
      }
      solution += direction * step.asDiagonal();
      residual -= image * step.asDiagonal();
      advance(residual, direction, energy);
    }
    if ((energy.array() > end.array()).any()) return {};
    return solution;
  }

private:
  /// The next directions; a column that has nothing left stays where it is.
  void advance(const MatrixXd& residual, MatrixXd& direction, VectorXd& energy) const {
    MatrixXd steepest = problem_.shifted.factor.solve(residual);
    project(steepest);
    const VectorXd next = column_products(residual, steepest);
    const VectorXd ratio = (energy.array() > 0.0).select(next.array() / energy.array(), 0.0);
    direction = steepest + direction * ratio.asDiagonal();
    energy = next;
  }

  void project(MatrixXd& vectors) const { vectors -= problem_.modes.vectors * (massed_.transpose() * vectors).eval(); }

  const SolvedEigenproblem& problem_;
  MatrixXd massed_;  ///< M Phi
};

/// Coefficients of the other modes in dPhi_G: phi_j^T f_k / (lambda_j - lambda), and 0 for the group's own.
MatrixXd expansion(const LowestModes& modes, const ModeGroup& group, const MatrixXd& forces) {
  MatrixXd coefficients = modes.vectors.transpose() * forces;
  const double value = group_value(modes, group);
  for (Index j = 0; j < modes.values.size(); ++j)
    coefficients.row(j) *= group.has(j) ? 0.0 : 1.0 / (modes.values[j] - value);
  return coefficients;
}

/// Tangent of the plane rotation that makes all matrices as diagonal as possible in rows p and q [CS96].
Eigen::JacobiRotation<double> best_rotation(const std::vector<MatrixXd>& matrices, Index p, Index q) {
  double on = 0.0, off = 0.0;
  for (const MatrixXd& A : matrices) {
    const double h = A(p, p) - A(q, q), o = 2.0 * A(p, q);
    on += h * h - o * o;
    off += 2.0 * h * o;
  }
  const double angle = 0.25 * std::atan2(off, on);
  return {std::cos(angle), -std::sin(angle)};
}

/// Whether neighbours of ascending rates are apart.
bool distinct(const VectorXd& rates) {
  const double apart = equal_rates * rates.cwiseAbs().maxCoeff();
  for (Index k = 1; k < rates.size(); ++k)
    if (rates[k] - rates[k - 1] <= apart) return false;
  return true;
}

}  // namespace

std::vector<ModeGroup> group_modes(const VectorXd& values, double tolerance) {
  std::vector<ModeGroup> groups;
  for (Index j = 0; j < values.size(); ++j)
    if (j > 0 && values[j] - values[j - 1] <= tolerance * std::abs(values[j]))
      ++groups.back().size;
    else
      groups.push_back({j, 1});
  return groups;
}

MatrixXd projected_derivative(const LowestModes& modes, const ModeGroup& group, const ModelDerivative& derivative) {
  const MatrixXd shapes = group_vectors(modes, group);
  const VectorXd values = modes.values.segment(group.first, group.size);
  const MatrixXd stiffness = shapes.transpose() * times(derivative.stiffness, shapes);
  const MatrixXd mass = shapes.transpose() * times(derivative.mass, shapes);
  return stiffness - 0.5 * (values.asDiagonal() * mass + mass * values.asDiagonal());
}

MatrixXd joint_eigenbasis(std::vector<MatrixXd> matrices) {
  for (MatrixXd& matrix : matrices)
    if (const double size = matrix.norm(); size > 0.0) matrix /= size;
  const Index g = matrices.front().rows();
  MatrixXd basis = MatrixXd::Identity(g, g);
  bool turned = g > 1;
  for (int sweep = 0; turned && sweep < most_sweeps; ++sweep) {
    turned = false;
    for (Index p = 0; p < g; ++p)
      for (Index q = p + 1; q < g; ++q) {
        const auto rotation = best_rotation(matrices, p, q);
        if (std::abs(rotation.s()) < rotation_end) continue;
        turned = true;
        basis.applyOnTheRight(p, q, rotation);
        for (MatrixXd& matrix : matrices) {
          matrix.applyOnTheRight(p, q, rotation);
          matrix.applyOnTheLeft(p, q, rotation.adjoint());
        }
      }
  }
  return basis;
}

std::optional<std::vector<MatrixXd>> subspace_derivatives(const SolvedEigenproblem& problem, const ModeGroup& group,
                                                          const std::vector<ModelDerivative>& derivatives,
                                                          const EigenSensitivityOptions& options) {
  const MatrixXd shapes = group_vectors(problem.modes, group);
  const auto parameters = static_cast<Index>(derivatives.size());
  MatrixXd forces(shapes.rows(), group.size * parameters);
  for (Index p = 0; p < parameters; ++p)
    forces.middleCols(p * group.size, group.size) =
        -unbalance(problem.modes, group, derivatives[static_cast<std::size_t>(p)]);
  const auto outside = Complement(problem).solve(group_value(problem.modes, group), forces, options);
  if (!outside) return {};
  const MatrixXd all = *outside + problem.modes.vectors * expansion(problem.modes, group, forces);

  std::vector<MatrixXd> result;
  for (Index p = 0; p < parameters; ++p) {
    const MatrixXd lengthening =
        shapes.transpose() * times(derivatives[static_cast<std::size_t>(p)].mass, shapes);  // Phi^T dM Phi
    result.emplace_back(all.middleCols(p * group.size, group.size) - 0.5 * shapes * lengthening);
  }
  return result;
}

std::optional<SplitEigenpairs> split_eigenpairs(const SolvedEigenproblem& problem, const ModeGroup& group,
                                                const ModelDerivative& derivative, const ModelDerivative& second,
                                                const EigenSensitivityOptions& options) {
  const auto moving = subspace_derivatives(problem, group, {derivative}, options);
  if (!moving) return {};
  const Eigen::SelfAdjointEigenSolver<MatrixXd> rates(projected_derivative(problem.modes, group, derivative));
  SplitEigenpairs pairs{rates.eigenvectors(), rates.eigenvalues(), {}};
  if (!distinct(pairs.values)) return pairs;

  const double lambda = group_value(problem.modes, group);
  const MatrixXd shapes = group_vectors(problem.modes, group) * pairs.basis;
  const MatrixXd mass = shapes.transpose() * times(derivative.mass, shapes);
  const MatrixXd outside = moving->front() * pairs.basis + 0.5 * shapes * mass;
  const MatrixXd forces = unbalance(problem.modes, group, derivative) * pairs.basis;
  const MatrixXd curvature =
      shapes.transpose() * (times(second.stiffness, shapes) - lambda * times(second.mass, shapes)) +
      2.0 * forces.transpose() * outside - 2.0 * mass * pairs.values.asDiagonal();
  MatrixXd rotation = -0.5 * mass;  // its diagonal keeps the length
  for (Index l = 0; l < group.size; ++l)
    for (Index k = 0; k < group.size; ++k)
      if (l != k) rotation(l, k) = curvature(l, k) / (2.0 * (pairs.values[k] - pairs.values[l]));
  pairs.vectors = outside + shapes * rotation;
  return pairs;
}

}  // namespace kalfem
