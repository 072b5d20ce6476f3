#include "kalfem/model/assembly/rbe3.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace kalfem {
namespace {

double mean_distance(const Mesh& mesh, const WeightedLink& link) {
  double sum = 0.0;
  for (const auto& share : link.shares) sum += (mesh.nodes.col(share.node) - mesh.nodes.col(link.follower)).norm();
  return sum > 0.0 ? sum / static_cast<double>(link.shares.size()) : 1.0;
}

/// Rotations counted by what they move at this distance: all six motions are in one unit.
RigidRow in_one_unit(RigidRow row, double length) {
  row.tail<3>() /= length;
  return row;
}

}  // namespace

MeanMotion::MeanMotion(const Mesh& mesh, const WeightedLink& link, const Axes& axes)
    : length_(mean_distance(mesh, link)) {
  std::vector<RigidRow> rows;
  std::vector<double> weights;
  for (const auto& share : link.shares) {
    const Eigen::Vector3d arm = mesh.nodes.col(share.node) - mesh.nodes.col(link.follower);
    const Eigen::Matrix3d own = axes ? axes(share.node) : Eigen::Matrix3d::Identity();
    for (int d = 0; d < 6; ++d) {
      if (!share.directions[static_cast<std::size_t>(d)]) continue;
      components_.push_back({share.node, d});
      rows.push_back(in_one_unit(rigid_row(d, arm, own), length_));
      weights.push_back(share.weight * (d < 3 ? 1.0 : length_ * length_));
    }
  }
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::Matrix<double, 6, Eigen::Dynamic> weighted(6, count);
  Matrix6 normal = Matrix6::Zero();
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    weighted.col(i) = weights[static_cast<std::size_t>(i)] * row.transpose();
    normal += weighted.col(i) * row;
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(6, 6);
  solver.setThreshold(1e-9);
  solver.compute(normal);
  resolution_ = solver.solve(Eigen::MatrixXd(normal));
  fit_ = solver.solve(Eigen::MatrixXd(weighted));
  fit_.bottomRows<3>() /= length_;
}

bool MeanMotion::determines(const RigidRow& row) const {
  const RigidRow wanted = in_one_unit(row, length_);
  return (wanted * resolution_ - wanted).cwiseAbs().maxCoeff() < 1e-6 * wanted.norm();
}

DofSum MeanMotion::follower_motion(int direction) const {
  const Eigen::RowVectorXd row = shares(rigid_row(direction, Eigen::Vector3d::Zero()));
  const double rounding = 1e-14 * std::max(1.0, 1.0 / length_);
  DofSum terms;
  for (Eigen::Index i = 0; i < row.size(); ++i)
    if (std::abs(row[i]) > rounding) terms.push_back({components_[static_cast<std::size_t>(i)], row[i]});
  return terms;
}

}  // namespace kalfem
