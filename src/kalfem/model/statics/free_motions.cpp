// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/free_motions.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <map>

#include "kalfem/model/assembly/hourglass.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"
#include "kalfem/model/checks/single_checks.hpp"
#include "kalfem/model/statics/equilibrium.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Rigid-body motions about the middle of the model, rotations scaled by its size, n x 6.
Eigen::MatrixXd scaled_motions(const FiniteElementModel& model, const AssembledModel& assembled,
                               const RigidFrame& frame) {
  Eigen::MatrixXd motions = rigid_body_modes(model, assembled, frame.centre);
  motions.rightCols<3>() /= frame.radius;
  return motions;
}

/// The largest rotation of a motion, of one without rotation the largest translation.
Index pivot_of(const Eigen::Matrix<double, 6, 1>& motion) {
  Index largest = 0;
  if (motion.tail<3>().cwiseAbs().maxCoeff(&largest) > 1e-6 * motion.norm()) return 3 + largest;
  motion.head<3>().cwiseAbs().maxCoeff(&largest);
  return largest;
}

/// Combinations of the six motions that neither move a held degree of freedom nor strain anything, as simple ones as
/// there are: the reduced row echelon form of the null space, translations first.
Matrix6X free_rigid_motions(const Eigen::MatrixXd& motions, const SparseMatrix& stiffness,
                            const std::vector<Index>& held) {
  const Eigen::VectorXd scale = stiffness.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd resisted = motions.transpose() * (stiffness * motions) / scale.squaredNorm();
  for (const auto place : held) resisted += motions.row(place).transpose() * motions.row(place);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(resisted);
  Eigen::MatrixXd space = spectrum.eigenvectors().leftCols((spectrum.eigenvalues().array() < 1e-10).count());
  std::map<Index, Index> columns;  // by pivot
  for (Index column = 0; column < space.cols(); ++column) {
    const Index pivot = pivot_of(space.col(column));
    space.col(column) /= space(pivot, column);
    columns[pivot] = column;
    for (Index other = 0; other < space.cols(); ++other)
      if (other != column) space.col(other) -= space(pivot, other) * space.col(column);
  }
  Matrix6X sorted(6, space.cols());
  Index place = 0;
  for (const auto& [pivot, column] : columns) sorted.col(place++) = space.col(column);
  return sorted.unaryExpr([](double value) { return std::abs(value) < 1e-6 ? 0.0 : value; });
}

std::string vector_in_words(const Eigen::Vector3d& vector) {
  char text[96];
  std::snprintf(text, sizeof text, "[%.3g, %.3g, %.3g]", vector[0], vector[1], vector[2]);
  return text;
}

/// "x" for an axis of coordinates, otherwise the vector.
std::string axis_in_words(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d unit = axis.normalized();
  for (Index i = 0; i < 3; ++i)
    if (std::abs(unit[i]) > 1.0 - 1e-6) return direction_names[static_cast<std::size_t>(i)];
  return vector_in_words(unit);
}

/// A rigid motion turns about the line through centre + (r x t) / |r|^2, with the rotation r and the translation t of
/// the centre, and moves along it.
std::string motion_in_words(const Eigen::Matrix<double, 6, 1>& motion, const RigidFrame& frame) {
  const Eigen::Vector3d translation = motion.head<3>(), rotation = motion.tail<3>() / frame.radius;
  if (rotation.isZero(0.0)) return "move along " + axis_in_words(translation);
  const Eigen::Vector3d place = frame.centre + rotation.cross(translation) / rotation.squaredNorm();
  return "turn about " + axis_in_words(rotation) + " through " + vector_in_words(place) + " m";
}

}  // namespace

InvalidInput free_to_move(const FiniteElementModel& model, const AssembledModel& assembled,
                          const std::vector<Index>& held) {
  const SparseMatrix stiffness = evaluate(assembled.stiffness, assembled.parameters);
  const RigidFrame frame = box_frame(model.mesh);
  const Matrix6X rigid = free_rigid_motions(scaled_motions(model, assembled, frame), stiffness, held);
  std::string words;
  for (const auto& motion : rigid.colwise()) words += (words.empty() ? "" : ", ") + motion_in_words(motion, frame);
  if (!words.empty())
    return {"'" + model.name + "' is free to move: it can " + words, "under a load its displacement has no bounds",
            "add supports, springs to ground or imposed motions"};
  const auto mechanisms = find_mechanisms(model, assembled, stiffness);
  if (mechanisms.empty())
    return {"the stiffness of '" + model.name + "' is almost singular", "under a load its displacement has no bounds",
            "check for springs and materials that are far softer than the rest"};
  const auto [why, fix] = mechanism_reason(model);
  const auto count = static_cast<Index>(mechanisms.size());
  return {"'" + model.name + "' is a mechanism: it moves without strain at " + report::listed(mechanisms, count), why,
          fix};
}

}  // namespace kalfem
