// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/rigid_motion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace kalfem {
namespace {

using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// A follower at node 0 of nodes in space, the last with rotations, of different weights.
struct Spread {
  Mesh mesh;
  WeightedLink link;

  Spread() {
    mesh.nodes.resize(3, 5);
    mesh.nodes << 0.1, 1.0, -0.7, 0.2, 0.9,  //
        -0.3, 0.4, 0.8, -1.1, 0.6,           //
        0.2, 0.1, 0.5, -0.4, 1.3;
    for (Eigen::Index node = 1; node < 5; ++node) link.shares.push_back({node, 0.5 * static_cast<double>(node)});
    link.shares.back().directions = {true, false, true, true, false, true};
  }

  /// The same follower and nodes on a line through two points.
  void straighten(const Vector3d& from, const Vector3d& to) {
    for (Eigen::Index node = 1; node < 5; ++node) mesh.nodes.col(node) = from + 0.3 * double(node) * (to - from);
    for (auto& share : link.shares) share.directions = {true, true, true, false, false, false};
  }
};

/// Axes of its own for each node.
Eigen::Matrix3d turned(Eigen::Index node) {
  return Eigen::AngleAxisd(0.4 * static_cast<double>(node), Vector3d(1, 2, -1).normalized()).toRotationMatrix();
}

/// The components of a mean motion where every node moves rigidly with the follower.
Eigen::VectorXd rigid_components(const Spread& spread, const MeanMotion& mean, const Vector6& q) {
  Eigen::VectorXd z(static_cast<Eigen::Index>(mean.components().size()));
  const Vector3d shift = q.head<3>(), turn = q.tail<3>();
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const auto [node, direction] = mean.components()[static_cast<std::size_t>(i)];
    const Vector3d arm = spread.mesh.nodes.col(node) - spread.mesh.nodes.col(0);
    const Vector3d moved = direction < 3 ? Vector3d(shift + turn.cross(arm)) : turn;
    z[i] = turned(node).col(direction % 3).dot(moved);
  }
  return z;
}

/// All six shares of the follower's motion.
Eigen::MatrixXd fit(const MeanMotion& mean) {
  Eigen::MatrixXd all(6, static_cast<Eigen::Index>(mean.components().size()));
  for (int d = 0; d < 6; ++d) all.row(d) = mean.shares(rigid_row(d, Vector3d::Zero()));
  return all;
}

TEST(MeanMotion, OfARigidMotionIsThatMotion) {
  const Spread spread;
  const MeanMotion mean(spread.mesh, spread.link, turned);
  const Vector6 q = (Vector6() << 0.3, -0.2, 0.5, 0.01, 0.04, -0.03).finished();
  EXPECT_LT((fit(mean) * rigid_components(spread, mean, q) - q).norm(), 4e-15);  // rounding
  for (int d = 0; d < 6; ++d) EXPECT_TRUE(mean.determines(d));
}

/// What is left over is at right angles, by the weights, to every rigid motion.
TEST(MeanMotion, OfAnyMotionIsTheClosestByTheWeights) {
  const Spread spread;
  const MeanMotion mean(spread.mesh, spread.link, turned);
  const Eigen::VectorXd z =
      Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(mean.components().size()), -1, 2).array().sin();
  const Vector6 q = fit(mean) * z;
  const Eigen::VectorXd rest = z - rigid_components(spread, mean, q);
  double distance = 0.0;
  for (Eigen::Index node = 1; node < 5; ++node)
    distance += (spread.mesh.nodes.col(node) - spread.mesh.nodes.col(0)).norm() / 4.0;
  for (int d = 0; d < 6; ++d) {
    const Eigen::VectorXd motion = rigid_components(spread, mean, Vector6::Unit(d));
    double product = 0.0;
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const auto [node, direction] = mean.components()[static_cast<std::size_t>(i)];
      product += 0.5 * static_cast<double>(node) * (direction < 3 ? 1.0 : distance * distance) * motion[i] * rest[i];
    }
    EXPECT_NEAR(product, 0.0, 1.5e-14) << d;  // rounding of sums
  }
}

TEST(MeanMotion, NodesOnALineDoNotTellTheRotationAboutIt) {
  Spread spread;
  const Vector3d from(0.1, -0.3, 0.2), to(1.1, 0.5, -0.4);  // through the follower
  spread.straighten(from, to);
  const MeanMotion mean(spread.mesh, spread.link);
  const Vector3d along = (to - from).normalized(), across = along.cross(Vector3d::UnitX()).normalized();
  EXPECT_FALSE(mean.determines(rotation_row(along)));
  EXPECT_TRUE(mean.determines(rotation_row(across)));
  EXPECT_TRUE(mean.determines(displacement_row(across, Vector3d::Zero())));
  EXPECT_FALSE(mean.determines(3));  // it has a part along the line
}

/// Two nodes share a displacement as a lever does.
TEST(MeanMotion, IsTheLeverOfTwoNodes) {
  Mesh mesh;
  mesh.nodes.resize(3, 3);
  mesh.nodes << 0.25, 0.0, 1.0, 0, 0, 0, 0, 0, 0;
  WeightedLink link;
  link.shares = {{1, 1.0}, {2, 1.0}};
  const auto terms = MeanMotion(mesh, link).follower_motion(2);
  ASSERT_EQ(terms.size(), 2u);
  EXPECT_EQ(terms[0].first, (NodalDof{1, 2}));
  EXPECT_NEAR(terms[0].second, 0.75, 2e-15);  // rounding
  EXPECT_NEAR(terms[1].second, 0.25, 2e-15);
}

}  // namespace
}  // namespace kalfem
